"""Beam searches, shared by the planners.

1. :mod:`.greedy_order`: the cheapest legal target again and again.
2. :mod:`.exchange_rates`: what an hour and a km/s are worth, by which partial plans are compared.
3. :mod:`.beams`, :mod:`.varied_beams`, :mod:`.timely_beams`: beams, with drawn settings, in time.
4. :mod:`solvers.orders.connection_table`, :mod:`solvers.orders.fronts`,
   :mod:`solvers.orders.bit_orders`, :mod:`solvers.orders.string_removal`: where planes drift,
   orders timed from both ends on hundreds of connections a pair; strings of targets are taken out
   of them and put back in.
"""
