"""Isosurfaces of a volume in a notebook that supports anywidget, such as Jupyter.

    from isosplat_widget import IsosplatWidget

    view = IsosplatWidget("http://localhost:8080/v1/volumes/head", isovalue=60.5)
    view                      # shows it
    view.isovalue = 180       # the picture follows
    view.observe(print, "isovalue")   # and the program follows what is done in the picture

Needs anywidget. The volume is served by `isosplat serve --cors ORIGIN`, where ORIGIN is that of the
notebook's page, such as http://localhost:8888: the browser reads the volume, not the kernel.
"""

# mypy: ignore-errors
import math

import anywidget
import traitlets


def _module_beside(name, address):
    """The address of the widget's module on the server that has the volume or the scene."""
    kind = "scenes" if name == "scene" else "volumes"
    server, separator, _ = address.partition(f"/v1/{kind}/") if isinstance(address, str) else ("", "", "")
    if not separator or not server.startswith(("http://", "https://")):
        raise ValueError(
            f"{name}: expected http(s)://SERVER/v1/{kind}/NAME, found {address!r}. For one elsewhere, give"
            " module= the address of isosplat-anywidget.js on a server or published site."
        )
    return server + "/isosplat-anywidget.js"


def _plain(value):
    """The value with NumPy's arrays and numbers as lists and numbers of Python, which JSON has."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return _plain(value.tolist()) if hasattr(value, "tolist") else value


class _Plain:
    """A trait that takes NumPy's arrays and numbers as well, and stores values that JSON can represent."""

    def validate(self, obj, value):
        return super().validate(obj, _plain(value))


class _Bool(_Plain, traitlets.Bool):
    pass


class _List(_Plain, traitlets.List):
    pass


class _Dict(_Plain, traitlets.Dict):
    pass


class IsosplatWidget(anywidget.AnyWidget):
    """A view of a volume. Traits are those of the element <isosplat-viewer>.

    src: the address of a volume of a server, or of a store on any host that answers Range requests.
    scene: the address of a scene, which is shown instead of src.
    module: the address of isosplat-anywidget.js. Required unless src is a volume, or scene a scene, of
        an Isosplat server, which serves the module itself.
    """

    _esm = traitlets.Unicode().tag(sync=True)

    src = traitlets.Unicode().tag(sync=True)
    #: The address of a bundle or of a scene.json.
    scene = traitlets.Unicode().tag(sync=True)
    #: The number of the step that is shown, of a scene that changes with time. None: the first one.
    step = traitlets.CInt(None, allow_none=True).tag(sync=True)
    #: Further volumes in the picture: [{"src": address, "name": "Dose", "group": "", "visible": True,
    #: "surfaces": as below, "transform": 16 numbers row by row}, …]. Only src is required.
    layers = _List(traitlets.Dict()).tag(sync=True)
    #: The isovalue of the first surface. None: the first suggested isovalue of the volume.
    isovalue = traitlets.CFloat(None, allow_none=True).tag(sync=True)
    #: All surfaces: [{"isovalue": 60.5, "colour": "#d9ccb3", "opacity": 1}, …]
    surfaces = _List(traitlets.Dict()).tag(sync=True)
    #: {"target": [x, y, z], "distance": …, "azimuth": …, "elevation": …, "roll": …, "fieldOfView": …,
    #: "projection": "perspective" or "orthographic"}, in degrees. Omitted values do not change.
    camera = _Dict(default_value=None, allow_none=True).tag(sync=True)
    #: {"low": [x, y, z], "high": [x, y, z], "planes": [{"normal": [x, y, z], "offset": d}, …],
    #: "caps": True}; low and high are fractions of the volume's extent. A plane keeps points with
    #: normal · position >= offset, in world coordinates. caps: closes the cut faces.
    clip = _Dict(default_value=None, allow_none=True).tag(sync=True)
    #: Planes that show values: {"along": [x, y, z], "plane": {"normal": [x, y, z], "offset": d},
    #: "range": [black, white]}; along has fractions of the volume's extent, None for no slice. The
    #: plane has normal · position = offset, in world coordinates.
    slices = _Dict(default_value=None, allow_none=True).tag(sync=True)
    #: rrggbb. Empty: white.
    background = traitlets.Unicode().tag(sync=True)
    controls = _Bool(True).tag(sync=True)
    #: The overlays above the picture, some of "axes,scale,box,clip".
    show = traitlets.Unicode().tag(sync=True)
    #: Widgets with the same name share camera, isovalues, clipping, slices and time.
    link = traitlets.Unicode().tag(sync=True)
    #: As in CSS: "30rem". Empty: three quarters of the width.
    height = traitlets.Unicode().tag(sync=True)

    # Reported by the picture.
    state = traitlets.Unicode(read_only=True).tag(sync=True)
    complete = traitlets.Bool(read_only=True).tag(sync=True)
    #: The present fault and its remedy. Empty: none.
    fault = traitlets.Unicode(read_only=True).tag(sync=True)
    #: voxels, spacing, origin, range, suggested_isovalues
    volume = traitlets.Dict(default_value=None, allow_none=True, read_only=True).tag(sync=True)
    #: values and unit of the scene's steps. None: the picture does not change with time.
    time = traitlets.Dict(default_value=None, allow_none=True, read_only=True).tag(sync=True)
    #: The point of the surface that was clicked last: position, voxel, normal, isovalue,
    #: layer (its name) and label (value, voxels and volume; None: the layer shows no label)
    picked = traitlets.Dict(default_value=None, allow_none=True, read_only=True).tag(sync=True)

    def __init__(self, src="", *, module=None, **traits):
        unknown = [name for name in traits if not self.has_trait(name) or name.startswith("_")]
        if unknown:
            raise TypeError(f"expected traits of IsosplatWidget ({_settable()}), found {', '.join(unknown)}")
        scene = traits.get("scene", "")
        beside = ("scene", scene) if scene else ("src", src)
        super().__init__(src=src, _esm=module or _module_beside(*beside), **traits)

    def __setattr__(self, name, value):
        # Otherwise a misspelt name would have no effect, and raise no error.
        if not name.startswith("_") and not hasattr(self, name):
            raise AttributeError(f"expected a trait of IsosplatWidget ({_settable()}), found {name}")
        super().__setattr__(name, value)

    @traitlets.validate("isovalue")
    def _validate_isovalue(self, proposal):
        value = proposal["value"]
        if value is not None and not math.isfinite(value):
            raise traitlets.TraitError(f"isovalue: expected a finite number, found {value}")
        return value


def _settable():
    """The names of the traits that a program sets."""
    traits = IsosplatWidget.class_own_traits().items()
    return ", ".join(sorted(name for name, trait in traits if name[0] != "_" and not trait.read_only))
