"""Orienteering with time windows, static and time-dependent, after Verbeeck.

C. Verbeeck, P. Vansteenwegen and E.-H. Aghezzaf, "The time-dependent orienteering problem with time
windows: a fast ant colony system", Annals of Operations Research 254, 2017, 481–505.
"""
