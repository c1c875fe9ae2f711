"""The live report page: edit a field, plan and view it, on this machine only.

:mod:`.drafts` is what is edited, with its history; :mod:`.folder` where it is kept; :mod:`.work`
plans in a thread; :mod:`.session` joins the three. :mod:`.guard`, :mod:`.app` and :mod:`.server`
put a page in front of it, by Starlette and uvicorn (extra ``[serve]``), imported nowhere else.
"""
