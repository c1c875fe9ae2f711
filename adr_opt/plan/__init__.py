"""What is flown, as data: plans, refined plans, certificates, and what follows from them."""
