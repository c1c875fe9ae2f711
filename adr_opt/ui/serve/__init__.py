"""The live page: from a catalogue to checked plans in a browser, on this machine only.

:mod:`.drafts` is what is edited and :mod:`.history` how it came to be; :mod:`.project` has the
files that keep it, in the folder of :mod:`.folder`. :mod:`.work` plans in a thread, which lives in
the process of :mod:`.planner_worker`, and :mod:`.planner_process` speaks with that one.
:mod:`.session` joins these. :mod:`.objects` makes missions of dropped files, :mod:`.jobs` runs all
other verbs, :mod:`.forms` knows the fields of an instance; :mod:`.backend` is all of it together.
:mod:`.guard`, :mod:`.app` and :mod:`.server` put a page in front of it, by Starlette and uvicorn
(extra ``[serve]``), imported nowhere else.
"""
