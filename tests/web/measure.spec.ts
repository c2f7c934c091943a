import { describe, expect, it } from "vitest";
import {
  angleOf,
  lengthOf,
  longestText,
  type Measurement,
  mostMeasurements,
  mostPointsInAll,
  voxelOf,
} from "../../web/measure/measurement.ts";
import { readMeasurement, toCsv, writeMeasurement } from "../../web/measure/measurement_text.ts";
import {
  largestSession,
  readSession,
  SessionError,
  writeSession,
} from "../../web/measure/session_file.ts";

const at = (x: number, y: number, z: number) => ({
  position: [x, y, z] as [number, number, number],
});

describe("measurements", () => {
  it("have lengths along all their points", () => {
    expect(lengthOf([at(1, 2, 3), at(4, 6, 3)])).toBe(5);
    expect(lengthOf([at(0, 0, 0), at(1, 0, 0), at(1, 2, 0), at(1, 2, 3)])).toBe(6);
  });

  it("have angles at their second point, precise for small ones as well", () => {
    expect(angleOf([at(1, 0, 0), at(0, 0, 0), at(0, 0, 7)])).toBeCloseTo(90, 12);
    expect(angleOf([at(1, 0, 0), at(0, 0, 0), at(-3, 0, 0)])).toBeCloseTo(180, 12);
    const small = (angleOf([at(1, 0, 0), at(0, 0, 0), at(1, 1e-7, 0)]) ?? 0) * (Math.PI / 180);
    expect(Math.abs(small / 1e-7 - 1)).toBeLessThan(1e-9);
    expect(angleOf([at(1, 1, 1), at(1, 1, 1), at(2, 0, 0)])).toBeUndefined();
  });

  it("are in voxels, also of sheared grids", () => {
    // Columns are the axes.
    const direction = [1, 0.6, 0, 0, 0.8, 0, 0, 0, 1];
    const grid = { origin: [10, 20, 30], spacing: [2, 3, 4], direction } as const;
    // World = origin + direction · (spacing ∘ (5, 7, 9)).
    const world = [10 + 10 + 0.6 * 21, 20 + 0.8 * 21, 30 + 36] as [number, number, number];
    const voxel = voxelOf({ ...grid, origin: [10, 20, 30], spacing: [2, 3, 4] }, world);
    for (const [i, expected] of [5, 7, 9].entries()) expect(voxel[i]).toBeCloseTo(expected, 12);
  });

  it("read as they were written in links", () => {
    const all: Measurement[] = [
      { kind: "point", points: [at(1.5, -2.25, 1e-3)] },
      { kind: "distance", points: [at(0, 0, 0), at(1, 2, 3)], text: "a, b | c" },
      { kind: "path", points: [at(0, 0, 0), at(1, 2, 3), at(-4, 5, 6), at(7, 8, 9)] },
      { kind: "angle", points: [at(0, 0, 0), at(1, 2, 3), at(-4, 5, 6)] },
      { kind: "note", points: [at(1, 2, 3)], text: "Größe <b>?&#" },
      { kind: "point", points: [{ ...at(1, 2, 3), level: 2 }], text: "from coarse cells" },
    ];
    for (const each of all) expect(readMeasurement(writeMeasurement(each))).toEqual(each);
    // Positions keep the digits of single precision.
    const [third] = readMeasurement(writeMeasurement({ kind: "point", points: [at(1 / 3, 0, 0)] }))
      ?.points ?? [at(0, 0, 0)];
    expect(Math.abs((third?.position[0] ?? 0) - 1 / 3)).toBeLessThan(1e-8);
  });

  it.each([
    "",
    "circle,1,2,3",
    "point",
    "point,1,2",
    "point,1,2,3,4,5,6",
    "point,1,2,x",
    "point,1,2,",
    "point,1,2,1e999",
    "distance,1,2,3",
    "note,1,2,3",
    "point@x,1,2,3",
    "point@,1,2,3",
    "point@100,1,2,3",
    `note,1,2,3|${"x".repeat(longestText + 1)}`,
    `path${",1,2,3".repeat(501)}`,
    "__proto__,1,2,3",
  ])("ignores %j", (line) => expect(readMeasurement(line)).toBeUndefined());

  it("are tables in which no text becomes a formula or another cell", () => {
    const csv = toCsv([
      {
        kind: "distance",
        points: [{ ...at(0, 0, 0), value: 60.5, normal: [0, 0, 1], level: 2 }, at(3, 4, 0)],
        voxels: [
          [0, 0, 0],
          [1.5, 2, 0],
        ],
        length_mm: 5,
        text: '=HYPERLINK("x"), y',
      },
    ]);
    expect(csv.split("\r\n")).toEqual([
      "number,kind,text,point,x_mm,y_mm,z_mm,voxel_x,voxel_y,voxel_z,value,normal_x,normal_y,normal_z,level,length_mm,angle_degrees",
      `1,distance,"'=HYPERLINK(""x""), y",1,0,0,0,0,0,0,60.5,0,0,1,2,5,`,
      `1,distance,"'=HYPERLINK(""x""), y",2,3,4,0,1.5,2,0,,,,,,,`,
      "",
    ]);
  });
});

describe("tables", () => {
  it("have the field that was shown, in columns of its own", () => {
    const dose = { name: "=dose", value: 2.5, units: "Gy" };
    const points = [{ ...at(0, 0, 0), field: dose }, at(3, 4, 0)];
    const lines = toCsv([{ kind: "distance", points, voxels: [] }]).split("\r\n");
    expect(lines[0]).toMatch(/,angle_degrees,field,field_value,field_units$/);
    expect(lines[1]).toMatch(/,'=dose,2.5,Gy$/);
    expect(lines[2]).toMatch(/,,,$/);
    expect(lines.slice(1, 3).map((line) => line.split(",").length)).toEqual([20, 20]);
  });
});

describe("session files", () => {
  const session = {
    view: "?volume=head&isovalue=60.5",
    contentId: "abc",
    measurements: [
      { kind: "point", points: [{ ...at(1, 2, 3), value: 60.5, normal: [0, 0, 1], level: 0 }] },
      { kind: "note", points: [at(1, 2, 3)], text: "here" },
      {
        kind: "point",
        points: [{ ...at(1, 2, 3), field: { name: "dose", value: -2.5, units: "Gy" } }],
      },
      { kind: "point", points: [{ ...at(1, 2, 3), field: { name: "dose", value: 0 } }] },
    ] as Measurement[],
  };

  it("read as they were written", () => {
    expect(readSession(writeSession(session))).toEqual(session);
  });

  const change = (part: object) =>
    JSON.stringify({ ...JSON.parse(writeSession(session)), ...part });
  const point = { kind: "point", points: [{ position: [1, 2, 3] }] };
  it.each<[string, string, RegExp]>([
    ["no JSON", "ISOSPLAT", /expected a session file \(JSON\)/],
    ["another file", "[1, 2]", /"format": "isosplat-session"/],
    ["null", "null", /"format"/],
    ["a later version", change({ version: 2 }), /version 1 .* found 2: open it with a newer page/],
    ["no view", change({ view: undefined }), /"view"/],
    ["an address in place of a query", change({ view: "https://example.org" }), /"view"/],
    ["a view without end", change({ view: `?${"x".repeat(1_000_000)}` }), /"view"/],
    ["measurements of another type", change({ measurements: {} }), /"measurements"/],
    [
      "too many measurements",
      change({ measurements: Array(mostMeasurements + 1).fill(point) }),
      /at most 500/,
    ],
    [
      "an unknown kind",
      change({ measurements: [{ ...point, kind: "x" }] }),
      /measurement 1: .*kind/,
    ],
    [
      "too few points",
      change({ measurements: [point, { ...point, kind: "angle" }] }),
      /measurement 2: expected 3/,
    ],
    [
      "a position that is no number",
      change({ measurements: [{ kind: "point", points: [{ position: [1, 2, "3"] }] }] }),
      /three finite numbers/,
    ],
    [
      "a position of two numbers",
      change({ measurements: [{ kind: "point", points: [{ position: [1, 2] }] }] }),
      /three finite numbers/,
    ],
    [
      "a note without text, which a link could not have",
      change({ measurements: [{ ...point, kind: "note" }] }),
      /for notes at least one/,
    ],
    [
      "too many points",
      change({
        measurements: Array(21).fill({ kind: "path", points: Array(500).fill(point.points[0]) }),
      }),
      /at most 10000 points in all measurements, found 10500/,
    ],
    ["a text that is no text", change({ measurements: [{ ...point, text: 5 }] }), /"text"/],
    ["too large a file", " ".repeat(largestSession + 1), /at most 5000000 bytes/],
  ])("refuses %s", (_name, text, message) => {
    expect(() => readSession(text)).toThrow(SessionError);
    expect(() => readSession(text)).toThrow(message);
  });

  it("have space for the maximum number of measurements", () => {
    const third = -1 / 3;
    const path: Measurement = {
      kind: "path",
      points: Array(mostPointsInAll / mostMeasurements).fill({
        ...at(third, third, third),
        value: third,
        normal: [third, third, third],
        level: 12,
      }),
      text: "\u0001".repeat(longestText), // takes most bytes in JSON
    };
    const measurements = Array(mostMeasurements).fill(path);
    expect(readSession(writeSession({ ...session, measurements })).measurements).toHaveLength(500);
  });

  it("drop everything that the format does not have", () => {
    const text = change({
      measurements: [
        {
          ...point,
          points: [
            { position: [1, 2, 3], value: "x", field: { name: "dose", value: "2" }, more: 1 },
          ],
          more: 2,
        },
      ],
    });
    expect(readSession(text).measurements).toEqual([point]);
  });
});
