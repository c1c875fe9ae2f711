"""The time-dependent travelling salesperson with windows: least end of a tour of all customers.

130 instances with speeds by zones of time, after Ichoua, Gendreau and Potvin (EJOR 144, 2003), made
by Arigliano and others and passed on by Lera-Romero, Miranda-Bront and Soulignac.
"""
