"""Plans as data: plans, refined plans, certificates, and quantities derived from them."""
