"""The benchmark behind `bench/run_all.py`.

One way through: ``options`` says what is asked for, ``methods`` and ``trials`` name it, ``runner``
hands tasks to a backend (``processes`` or ``cluster``), ``work`` does one in a worker, ``store``
keeps every row as it is finished, and ``report`` makes the page from the rows alone.
"""
