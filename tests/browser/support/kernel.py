"""A kernel for tests of isosplat.view() in a browser: kernel.py widget|html STORE [PROXY].

Lines of JSON on both sides. It writes what the kernel would send: first {"state": traits} or {"html": text}, then
{"state"} with changed traits, and {"message", "buffers"} in base64. It reads {"state"} and {"message"} of the
page, and {"set": traits}, an assignment of the program; {"get": names} is answered by {"values"}.

anywidget is not in Debian: AnyWidget is here a class with its traits and its messages alone.
"""

import base64
import json
import sys
import types

import isosplat


def write(line):
    print(json.dumps(line), flush=True)


def fake_anywidget():
    import traitlets

    class AnyWidget(traitlets.HasTraits):
        _from_page = None

        def __init__(self, **traits):
            super().__init__(**traits)
            names = list(self.traits(sync=True))
            write({"state": {name: getattr(self, name) for name in names}})
            self.observe(self._send_state, names)

        def _send_state(self, change):
            # ipywidgets does not send a value back to where it comes from.
            if self._from_page is None or self._from_page.get(change.name) != change.new:
                write({"state": {change.name: change.new}})

        def on_msg(self, callback):
            self._callback = callback

        def send(self, content, buffers=None):
            write({"message": content, "buffers": [base64.b64encode(b).decode() for b in buffers or []]})

    sys.modules["anywidget"] = types.SimpleNamespace(AnyWidget=AnyWidget)


def main(kind, store, proxy=""):
    if kind == "widget":
        fake_anywidget()
    view = isosplat.view(store, 100, proxy=proxy, height="300px")
    if kind == "html":
        write({"html": view._repr_html_()})
    for line in sys.stdin:
        received = json.loads(line)
        if "state" in received:
            view._from_page = received["state"]
            for name, value in received["state"].items():
                view.set_trait(name, value)
            view._from_page = None
        elif "message" in received:
            view._callback(view, received["message"], [])
        elif "set" in received:
            for name, value in received["set"].items():
                setattr(view, name, value)
        elif "get" in received:
            write({"values": {name: getattr(view, name) for name in received["get"]}})


main(*sys.argv[1:])
