import { describe, expect, it } from "vitest";
import { MarkPen } from "../../web/capture/mark_pen.ts";
import { marksSvg } from "../../web/capture/picture_marks.ts";
import { categoriesOf, merged } from "../../web/core/categories.ts";
import { parseMetadata } from "../../web/core/records.ts";
import type { FieldInfo, StoreInfo } from "../../web/core/types.ts";
import type { Screen } from "../../web/overlay/screen.ts";
import { listedLabels, mostListed } from "../../web/page/panel/legend.ts";
import { formatField } from "../../web/page/shell/format.ts";
import { FieldBins } from "../../web/stream/field_bins.ts";
import type { ShownField } from "../../web/stream/session.ts";
import { PictureSettings } from "../../web/viewer/picture_settings.ts";
import type { RendererModule } from "../../web/viewer/renderer_module.ts";
import { defaultLook, type Legend } from "../../web/viewer/types.ts";

const metadata = (categories: unknown) =>
  parseMetadata(new TextEncoder().encode(JSON.stringify({ name: "a", categories })));

describe("the labels of a field", () => {
  it("are those of its metadata, by value, each once", () => {
    const found = categoriesOf(
      metadata([
        [7, "#0a141e", "thalamus"],
        [0, "#9e9e9e"],
        [7, "#000000", "other"],
        [70_000, "#000000"],
      ]),
    );
    expect(found).toEqual([
      { value: 0, colour: "#9e9e9e", name: "" },
      { value: 7, colour: "#0a141e", name: "thalamus" },
    ]);
    expect(merged([found, [{ value: 3, colour: "#010203", name: "b" }]])).toHaveLength(3);
  });

  it("have names without control characters, and pictures have none that XML forbids", () => {
    const [found] = categoriesOf(metadata([[7, "#0a141e", "b\u0001\u001b[31mad\u007f"]]));
    expect(found?.name).toBe("b[31mad");
    const written = new MarkPen(12, "#ffffff").text("a\u0001\u001b\ufffe\ud800<ü🧠", 0, 0);
    expect(written).toMatch(/>a&#60;ü🧠<\/text>$/);
  });

  it("are left out if any of them is malformed", () => {
    for (const malformed of [
      7,
      [[1.5, "#000000"]],
      [[1, "red"]],
      [[1]],
      [[1, "#000000", 5]],
      Array.from({ length: 513 }, (_, i) => [i, "#000000"]),
    ]) {
      expect(metadata(malformed).categories).toBeUndefined();
    }
    expect(categoriesOf(metadata([[1, "#000000", "a"]]))).toHaveLength(1);
  });

  it("are listed as far as the drawn chunks have them", () => {
    const bins = new FieldBins({
      mapping: { offset: -5, scale: 1, maxError: 0, bits: 16, hasMissing: true },
      range: [-5, 60_000],
      quantizedRange: [0, 60_005],
    } as FieldInfo);
    bins.add(1, Uint32Array.from([5 | (6 << 16), 5 | (6 << 16)]), true);
    bins.add(2, Uint32Array.from([(7 | (65_535 << 16)) >>> 0]), true);
    expect(bins.labels([1])).toEqual(new Set([0, 1]));
    expect(bins.labels([1, 2, 3])).toEqual(new Set([0, 1, 2]));
    bins.remove(2);
    expect(bins.labels([1, 2])).toEqual(new Set([0, 1]));
  });
});

describe("a legend of labels", () => {
  const categories = Array.from({ length: 20 }, (_, i) => ({
    value: i,
    colour: `#0000${(16 + i).toString(16)}`,
    name: i === 3 ? "" : `region ${i}`,
  }));
  const legend = (count: number): Legend => ({
    colourBy: "field",
    colours: [],
    range: null,
    categories: categories.slice(0, count),
  });

  it("lists a dozen, and states how many more there are", () => {
    expect(listedLabels(legend(mostListed)).labels).toHaveLength(mostListed);
    expect(listedLabels(legend(mostListed)).more).toBe(0);
    const { labels, more } = listedLabels(legend(20));
    expect(labels).toHaveLength(mostListed - 1);
    expect(more).toBe(20 - labels.length);
    expect(labels[3]?.text).toBe("label 3");
    expect(labels[2]).toEqual({ text: "region 2", colour: "#000012" });
  });

  it("has no range, scale or lines", () => {
    const settings = new PictureSettings();
    const field = { ...defaultLook.field, name: "region", steps: 4, lines: 10 };
    settings.look = { ...defaultLook, colourBy: "field", field };
    const renderer = { picture: { colours: () => ["red"] } } as unknown as RendererModule;
    const info = { range: [0, 1], spacing: [1, 1, 1], metadata: {} } as unknown as StoreInfo;
    const shown = {
      info: { mapping: { scale: 1, hasMissing: false }, range: [0, 20] },
      metadata: {},
    } as unknown as ShownField;
    expect(settings.legend(renderer, info, shown, categories)).toMatchObject({
      colours: [],
      range: null,
      categories,
    });
    expect(settings.legend(renderer, info, shown, categories)?.lines).toBeUndefined();
    expect(settings.legend(renderer, info, shown)?.lines).toBeDefined();
  });

  it("is drawn into pictures with its colours and names", () => {
    const labels = [{ text: "thalamus", colour: "#0a141e" }, { text: "and 3 more" }];
    const svg = marksSvg(
      {
        legend: { name: "region", colours: [], ends: ["", ""], labels, notes: ["Grey: no value"] },
      },
      {
        size: { width: 400, height: 300 },
        screen: {} as Screen,
        info: {} as StoreInfo,
        target: [0, 0, 0],
        background: "#ffffff",
      },
    );
    expect(svg).toContain('fill="#0a141e"');
    for (const text of ["region", "thalamus", "and 3 more", "Grey: no value"]) {
      expect(svg).toContain(`>${text}<`);
    }
    expect(svg).not.toContain("linearGradient");
  });
});

it("a point in a region is named", () => {
  expect(formatField({ name: "region", value: 7, label: "thalamus" })).toBe("region thalamus (7)");
  expect(formatField({ name: "region", value: 7 })).toBe("region 7");
});
