// The notebook widget without a browser: the values that it accepts, and the Python class with its
// traits.
import { spawnSync } from "node:child_process";
import { fileURLToPath } from "node:url";
import { describe, expect, it } from "vitest";
import {
  backgroundOf,
  cameraOf,
  clipOf,
  layersOf,
  reportedTraits,
  slicesOf,
  stepOf,
  surfacesOf,
  traitDefaults,
} from "../../web/element/notebook_traits.ts";
import type { Camera } from "../../web/viewer/index.ts";
import { sameValue } from "../../web/viewer/same_value.ts";

describe("the Python class", () => {
  const file = fileURLToPath(new URL("../../web/npm/python/isosplat_widget.py", import.meta.url));
  /** anywidget is not in Debian. Its AnyWidget is a traitlets.HasTraits, which declares the traits. */
  const script = `
import json, runpy, sys, types
try:
    import traitlets
except ImportError:
    sys.exit(3)
sys.modules["anywidget"] = types.SimpleNamespace(AnyWidget=traitlets.HasTraits)
Widget = runpy.run_path(sys.argv[1])["IsosplatWidget"]
view = Widget("https://host.example/ct/v1/volumes/head", isovalue=60.5)
def attempt(action):
    try:
        return action()
    except (ValueError, TypeError, AttributeError, traitlets.TraitError) as error:
        return type(error).__name__ + ": " + str(error)
def numbers():
    try:
        import numpy
    except ImportError:
        return None
    view.isovalue = numpy.float32(60.5)
    view.surfaces = [{"isovalue": numpy.uint8(7)}]
    view.camera = {"target": numpy.array([1.0, 2.0, 3.0]), "distance": numpy.int64(10)}
    view.clip = {"low": (0, numpy.float64(0.5), 0)}
    view.controls = numpy.bool_(False)
    view.surfaces = numpy.array(view.surfaces)
    return json.loads(json.dumps([view.isovalue, view.surfaces, view.camera, view.clip, view.controls]))
print(json.dumps({
    "defaults": {name: trait.default() for name, trait in Widget.class_traits(sync=True).items()},
    "readOnly": sorted(name for name, trait in Widget.class_traits().items() if trait.read_only),
    "view": [view._esm, view.src, view.isovalue],
    "module": Widget("head.isosplat", module="https://cdn.example/w.js")._esm,
    "scene": Widget(scene="https://host.example/v1/scenes/run", step=2)._esm,
    "noScene": attempt(lambda: Widget(scene="run.isobundle")._esm),
    "noModule": attempt(lambda: Widget("head.isosplat")._esm),
    "text": attempt(lambda: view.set_trait("isovalue", "sixty")),
    "set": attempt(lambda: setattr(view, "picked", {})),
    "unknown": attempt(lambda: Widget(view.src, isovalues=[1])),
    "misspelt": attempt(lambda: setattr(view, "isovalu", 3)),
    "noNumber": attempt(lambda: setattr(view, "isovalue", float("nan"))),
    "noText": attempt(lambda: Widget(5)),
    "private": attempt(lambda: Widget(view.src, _css="")),
    "numbers": numbers(),
}))
`;
  // Debian's Python, which has Debian's packages.
  const run = spawnSync("/usr/bin/python3", ["-B", "-c", script, file], { encoding: "utf8" });

  it.skipIf(run.status === 3 || run.error)("has the traits that the module reads", () => {
    expect(run.stderr).toBe("");
    const found = JSON.parse(run.stdout);
    expect(found.defaults).toEqual({ ...traitDefaults, _esm: "" });
    expect(found.readOnly).toEqual([...reportedTraits].sort());
    expect(found.view).toEqual([
      "https://host.example/ct/isosplat-anywidget.js",
      "https://host.example/ct/v1/volumes/head",
      60.5,
    ]);
    expect(found.module).toBe("https://cdn.example/w.js");
    expect(found.scene).toBe("https://host.example/isosplat-anywidget.js");
    expect(found.noScene).toMatch(/^ValueError: scene: expected .*\/v1\/scenes\/NAME, found 'run/);
    expect(found.noModule).toMatch(/^ValueError: src: expected .*found 'head.isosplat'.*module=/);
    expect(found.text).toMatch(/^TraitError/);
    expect(found.set).toMatch(/^TraitError/);
    expect(found.unknown).toMatch(/^TypeError: expected traits of .*isovalue.*, found isovalues$/);
    expect(found.unknown).not.toContain("picked");
    expect(found.misspelt).toMatch(/^AttributeError: expected a trait of .*, found isovalu$/);
    expect(found.noNumber).toMatch(/^TraitError: isovalue: expected a finite number, found nan$/);
    expect(found.noText).toMatch(/^ValueError: src: expected .*found 5/);
    expect(found.private).toMatch(/^TypeError: .*found _css$/);
    // Programs have numbers and arrays of NumPy.
    const numbers = [
      60.5,
      [{ isovalue: 7 }],
      { target: [1, 2, 3], distance: 10 },
      { low: [0, 0.5, 0] },
      false,
    ];
    if (found.numbers) expect(found.numbers).toEqual(numbers);
  });
});

describe("values of the program", () => {
  const camera: Camera = {
    target: [1, 2, 3],
    distance: 10,
    azimuth: 30,
    elevation: 20,
    roll: 0,
    fieldOfView: 30,
    projection: "perspective",
  };

  it("are completed and brought into one form", () => {
    expect(cameraOf({ azimuth: 90, more: 1 }, camera)).toEqual({ ...camera, azimuth: 90 });
    expect(cameraOf(null, camera)).toBeNull();
    expect(surfacesOf([{ isovalue: 1, colour: "C8553D" }])).toEqual([
      { isovalue: 1, colour: "#c8553d", opacity: 1 },
    ]);
    expect(clipOf({ low: [0, 0, 0], high: [1, 1, 0.5] })).toEqual({
      low: [0, 0, 0],
      high: [1, 1, 0.5],
      planes: [],
    });
    const capped = { low: [0, 0, 0], high: [1, 1, 0.5], planes: [], caps: true };
    expect(clipOf(capped)).toEqual(capped);
    const plane = { normal: [0, 1, 1], offset: 4 };
    expect(slicesOf({ plane, range: null })).toEqual({ along: [null, null, null], plane });
    const layer = { src: "dose.isosplat", surfaces: [{ isovalue: 1, colour: "C8553D" }] };
    expect(layersOf([layer, { src: "a", visible: false, transform: null }])).toEqual([
      {
        ...{ src: "dose.isosplat", name: "", group: "", visible: true },
        surfaces: [{ isovalue: 1, colour: "#c8553d", opacity: 1 }],
      },
      { src: "a", name: "", group: "", visible: false },
    ]);
    const across = { along: [0, null, 1], range: [-1, 100] };
    expect(slicesOf(across)).toEqual(across);
  });

  it.each([
    ["camera", () => cameraOf({ azimuth: 90 }, null)],
    ["camera", () => cameraOf({ distance: Number.NaN }, camera)],
    ["camera", () => cameraOf({ target: [1, 2] }, camera)],
    ["camera", () => cameraOf({ projection: "fisheye" }, camera)],
    ["camera", () => cameraOf([1], camera)],
    ["surfaces", () => surfacesOf({})],
    ["surfaces", () => surfacesOf([{ isovalue: "60", colour: "#c8553d" }])],
    ["surfaces", () => surfacesOf([{ isovalue: 60, colour: "red" }])],
    ["surfaces", () => surfacesOf([{ isovalue: 60, colour: "#c8553d", opacity: 2 }])],
    ["clip", () => clipOf({ low: [0, 0, 0] })],
    ["clip", () => clipOf({ low: [0, 0, 0], high: [1, 1, 1], planes: [{ normal: [1] }] })],
    ["clip", () => clipOf({ low: [0, 0, 0], high: [1, 1, 1], caps: "on" })],
    ["slices", () => slicesOf({ along: [0.5] })],
    ["slices", () => slicesOf({ along: [0.5, null, 2] })],
    ["slices", () => slicesOf({ plane: { normal: [0, 0, 0], offset: 1 } })],
    ["slices", () => slicesOf({ range: [2, 2] })],
    ["step", () => stepOf(1.5)],
    ["step", () => stepOf("2")],
    ["layers", () => layersOf({})],
    ["layers", () => layersOf([{ name: "Dose" }])],
    ["layers", () => layersOf([{ src: "a", visible: "no" }])],
    ["layers", () => layersOf([{ src: "a", surfaces: [{ isovalue: 1, colour: "red" }] }])],
    ["layers", () => layersOf([{ src: "a", transform: [1, 2, 3] }])],
    ["layers", () => layersOf([{ src: "a", transform: 5 }])],
    ["background", () => backgroundOf("white")],
  ])("are refused with what was expected: %s %#", (name, read) => {
    expect(read).toThrow(new RegExp(`^${name}: expected .*, found `));
  });

  it("are the same if they differ in the order of names only", () => {
    const { target, ...rest } = camera;
    expect(sameValue(camera, { ...rest, target: [...target] })).toBe(true);
    expect(sameValue(camera, rest)).toBe(false);
    expect(sameValue([1, 2], [1, 2, 3])).toBe(false);
    expect(sameValue([], {})).toBe(false);
    expect(sameValue(null, {})).toBe(false);
  });
});
