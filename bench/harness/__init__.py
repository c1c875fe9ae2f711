"""The benchmark behind `bench/run_all.py`.

One way through: ``options`` says what is asked for, ``methods`` and ``trials`` name it, ``work``
makes a row, ``results`` is the study of all rows and their file, and ``report`` makes the page from
that alone.
"""
