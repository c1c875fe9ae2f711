"""Text of a program that lists the kernels which Numba compiles from a call of ``listen`` on."""

LISTEN = """
from numba.core import event
compiled = []
class Listener(event.Listener):
    def on_start(self, event):
        compiled.append(event.data["dispatcher"].py_func.__qualname__)
    def on_end(self, event):
        pass
def listen():
    event.register("numba:compile", Listener())
"""
