import { describe, expect, it } from "vitest";
import { readSession, writeSession } from "../../web/measure/session_file.ts";
import { readUrl, type UrlState, writeUrl } from "../../web/page/address/url_state.ts";
import { defaultLight } from "../../web/viewer/light.ts";

const everything: UrlState = {
  volume: "engine",
  isovalues: [60.5, 180],
  colours: ["#d9ccb3", "#c8553d"],
  opacities: [0.4, 1],
  camera: {
    azimuth: 30.25,
    elevation: -12.5,
    distance: 512.125,
    target: [127.5, -3, 0.5],
    roll: 5,
    fieldOfView: 45,
  },
  projection: "orthographic",
  kind: "exact",
  shading: "exact",
  colourBy: "projection-error",
  colourMap: "magma",
  background: "#102030",
  eyeDome: 0.25,
  time: -12.5,
  show: new Set(["axes", "box"]),
  measures: ["distance,1,2,3,4,5,6.5|Länge, außen", "point,-1,0,1"],
  light: {
    azimuth: 60,
    elevation: -12.5,
    key: 0.8,
    sky: 1.5,
    rim: 0,
    highlight: 0.1,
    roughness: 0.75,
    occlusion: 0.5,
    occlusionRadius: 0.05,
    shadow: 0,
    shadowSoftness: 0.3,
  },
  clip: {
    low: [0, 0.25, 0],
    high: [1, 1, 0.5],
    planes: [{ normal: [0.6, 0, -0.8], offset: 12.5 }],
    caps: true,
  },
  slices: {
    along: [1 / 3, null, 0],
    plane: { normal: [0.6, -0.8, 1e-9], offset: -12.5 },
    range: [-1000.5, 1 / 3],
    mapped: true,
  },
};

describe("invalid parts of an address", () => {
  it("are ignored, and named", () => {
    const wrong = [
      "isovalue=abc",
      "camera=1,2",
      "camera=0,0,-5,0,0,0",
      "opacity=2",
      "kind=round",
      "kind=blended",
      "shading=flat",
      "colour=12",
      "clip=0,2,0,1,0,1",
      "plane=0,0,0,1",
      "clip-caps=maybe",
      "slices=0.5,,2",
      "slices=0.5,,-0.1",
      "slices=NaN,,0.5",
      "slices=Infinity,,",
      "slices=0.5",
      "slices=,,",
      "slices=0,0,0,0",
      "slice-plane=0,0,0,1",
      "slice-plane=1,0,0",
      "slice-plane=1,0,0,Infinity",
      "slice-plane=NaN,0,1,0",
      "slice-range=5,5",
      "slice-range=5",
      "slice-range=1,NaN",
      "slice-range=-Infinity,1",
      "slice-range=1,2,3",
      "shade=-1",
      "light=40",
      "light=0,100",
      "light-strength=1,1,1,1",
      "material=1,0",
      "occlusion=1.5",
      "shadow=1,",
    ];
    for (const parameter of wrong) {
      const { notes, ...rest } = readUrl(`?${parameter}`);
      expect(rest, parameter).toEqual({});
      expect(notes?.[0], parameter).toContain(parameter);
    }
    expect(readUrl("?isovalue=60.5&kind=exact").notes).toBeUndefined();
  });

  it("cannot make a surface invisible", () => {
    const { opacities, notes } = readUrl("?isovalue=60,70&opacity=0,0.5");
    expect(opacities).toEqual([0.05, 0.5]);
    expect(notes?.[0]).toContain("invisible");
  });
});

describe("the address of a view", () => {
  it("is read as it was written", () => {
    expect(readUrl(writeUrl(everything))).toEqual(everything);
  });

  it("is kept by a session file", () => {
    const { view } = readSession(writeSession({ view: writeUrl(everything), measurements: [] }));
    expect(readUrl(view)).toEqual(everything);
  });

  it("states that nothing of the scene's clipping, slices and measurements is shown", () => {
    const none: UrlState = {
      clip: { low: [0, 0, 0], high: [1, 1, 1], planes: [] },
      slices: { along: [null, null, null] },
      measures: [],
    };
    expect(writeUrl(none)).toBe("?clip=0,1,0,1,0,1&slices=none&measure=none");
    expect(readUrl(writeUrl(none))).toEqual(none);
  });

  it("keeps every digit", () => {
    const third = 1 / 3;
    const exact: UrlState = {
      isovalues: [100 * third],
      opacities: [third],
      camera: {
        azimuth: 37.2 + third,
        elevation: -third,
        distance: 417.36504030327 / 1.15,
        // A volume in map coordinates: seven digits would move it by half a unit.
        target: [4_649_776.22 + third, -third, 1e-9 * third],
        roll: third,
        fieldOfView: 30 + third,
      },
      eyeDome: third,
      clip: {
        low: [third, 0, 0],
        high: [1, 1, 2 * third],
        planes: [{ normal: [0.6, third, -0.8], offset: 4_649_776.22 + third }],
      },
    };
    expect(readUrl(writeUrl(exact))).toEqual(exact);
  });

  it("keeps short numbers as a person would type them", () => {
    expect(readUrl("?volume=engine&isovalue=60.5")).toEqual({
      volume: "engine",
      isovalues: [60.5],
    });
    expect(writeUrl({ volume: "engine", isovalues: [60.5, 70] })).toBe(
      "?volume=engine&isovalue=60.5,70",
    );
  });

  it("leaves out roll and field of view if they are the defaults", () => {
    const camera = { ...everything.camera, roll: 0, fieldOfView: 30 } as UrlState["camera"];
    const text = writeUrl({ camera } as UrlState);
    expect(text).toBe("?camera=30.25,-12.5,512.125,127.5,-3,0.5");
    expect(readUrl(text).camera).toEqual(camera);
  });

  it("carries a store's address with its own query", () => {
    const src = "https://example.org/a b.isosplat?x=1&y=2#z";
    expect(readUrl(writeUrl({ src })).src).toBe(src);
  });

  it.each([
    ["isovalue=abc", "isovalues"],
    ["isovalue=", "isovalues"],
    ["isovalue=1,,2", "isovalues"],
    ["isovalue=NaN", "isovalues"],
    ["isovalue=Infinity", "isovalues"],
    ["colour=red", "colours"],
    ["opacity=2", "opacities"],
    ["camera=1,2,3", "camera"],
    ["camera=1,2,-3,0,0,0", "camera"],
    ["camera=1,200,3,0,0,0", "camera"],
    ["kind=triangles", "kind"],
    ["colour-by=taste", "colourBy"],
    ["map=rainbow", "colourMap"],
    ["background=javascript:x", "background"],
    ["shade=7", "eyeDome"],
    ["clip=0,1,0,1,0.5,0.5", "clip"],
    ["clip=0,1,0,1,0,2", "clip"],
    ["plane=0,0,0,5", "clip"],
    ["plane=1,0,0", "clip"],
    ["plane=1,0,0,5,6", "clip"],
  ])("takes %s as missing", (query, key) => {
    expect(readUrl(`?${query}`)).not.toHaveProperty(key);
  });

  it("changes only the settings of the light that it names, and names only those that differ", () => {
    const { light } = readUrl("?light-strength=1.5&shadow=0");
    expect(light).toEqual({ ...defaultLight, key: 1.5, shadow: 0 });
    expect(writeUrl(light ? { light } : {})).toBe("?light-strength=1.5&shadow=0");
    expect(writeUrl({ light: { ...defaultLight, elevation: 10 } })).toBe("?light=-45,10");
    expect(writeUrl({ light: defaultLight })).toBe("");
  });

  it("accepts no more isosurfaces than can be drawn", () => {
    const many = Array.from({ length: 20 }, (_, i) => i).join(",");
    expect(readUrl(`?isovalue=${many}`).isovalues).toHaveLength(8);
  });
});

describe("the field that colours show", () => {
  const field = {
    name: "pressure, static",
    range: [-0.5, 1 / 3],
    scale: "symmetric",
    steps: 8,
    lines: 0.1 + 0.2,
  } as const;

  it("is the same after it was written and read", () => {
    const written = writeUrl({ colourBy: "field", field });
    expect(written).toContain("field-lines=0.30000000000000004");
    expect(readUrl(written)).toEqual({ colourBy: "field", field });
    const plain = { ...field, lines: 0 };
    expect(writeUrl({ colourBy: "field", field: plain })).not.toContain("field-lines");
    expect(readUrl(writeUrl({ colourBy: "field", field: plain })).field).toEqual(plain);
    for (const lines of [Number.POSITIVE_INFINITY, Number.NaN, -1]) {
      const none = { ...field, lines };
      expect(writeUrl({ colourBy: "field", field: none })).not.toContain("field-lines");
    }
  });

  it("has no contour lines at intervals that are none", () => {
    for (const interval of ["0", "-1", "NaN", "Infinity", "1e999", "5 Pa", "1,2"]) {
      const { field, notes } = readUrl(
        `?colour-by=field&field=p&field-lines=${encodeURIComponent(interval)}`,
      );
      expect(field?.lines).toBe(0);
      expect(notes?.join()).toContain(`field-lines=${interval}`);
    }
    expect(readUrl("?field=p&field-lines=1e-300").field?.lines).toBe(1e-300);
  });
});
