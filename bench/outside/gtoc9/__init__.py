"""GTOC9, the Kessler run: 123 debris to be removed by missions that are launched one by one.

Rules and costs after the statement of the problem (ESA, 2017; D. Izzo and M. Märtens, "The Kessler
run: on the design of the GTOC9 challenge", Acta Futura 11, 2018, 11–24).
"""
