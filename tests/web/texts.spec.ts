import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterEach, describe, expect, it, vi } from "vitest";
import { formatBytes, formatValue, parseValue } from "../../web/page/shell/format.ts";
import { translation } from "../../web/texts/de.ts";
import { element } from "../../web/texts/element.de.ts";
import { firstKnown } from "../../web/texts/languages.ts";
import { decimalSignOf, listed, plurals, writeNumbersAs } from "../../web/texts/numbers.ts";
import { trackedFiles } from "../support/source_graph.ts";
import { visibleTexts } from "../support/visible_texts.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));
const modules = import.meta.glob<Record<string, unknown>>(
  ["../../web/texts/*.ts", "!../../web/texts/*.de.ts"],
  { eager: true },
);
/** The objects of English texts by their parts: helpTexts belongs to the part help. */
const english = Object.fromEntries(
  Object.values(modules)
    .flatMap((module) => Object.entries(module))
    .flatMap(([name, value]) => (name.endsWith("Texts") ? [[name.slice(0, -5), value]] : [])),
);
const german: Record<string, unknown> = { ...translation, element };

type Text = string | ((...values: number[]) => unknown);

/** All texts of an object, by their paths. */
function textsIn(value: unknown, path: string): [string, Text][] {
  if (typeof value === "string" || typeof value === "function") return [[path, value as Text]];
  return Object.entries(value as object).flatMap(([key, each]) => textsIn(each, `${path}.${key}`));
}

/** A text as a string. Functions are called with these values. */
function said(text: Text | undefined, values: number[] = [12, 23, 34, 45]): string {
  const result = typeof text === "function" ? text(...values) : text;
  return Array.isArray(result) ? result.join("") : String(result);
}

/** Texts that are the same in German. */
const same = [
  "device.numbered.segment",
  "measure.text",
  "panel.fieldScales.linear",
  "panel.quantities.gradient",
  "panel.splats",
];

describe("German", () => {
  const ofEnglish = textsIn(english, "");
  const ofGerman = new Map(textsIn(german, ""));

  it("has every text of English, and no other", () => {
    expect(ofEnglish.length).toBeGreaterThan(400);
    expect([...ofGerman.keys()].sort()).toEqual(ofEnglish.map(([path]) => path).sort());
  });

  it.each([
    ["one", [1, 1, 1, 1]],
    ["more", [12, 23, 34, 45]],
  ])("has the same numbers as English: %s", (_, values) => {
    const numbers = (text: Text | undefined) => (said(text, values).match(/\d+/g) ?? []).sort();
    for (const [path, text] of ofEnglish) {
      expect([path, ...numbers(ofGerman.get(path))]).toEqual([path, ...numbers(text)]);
    }
  });

  it("keeps the placeholders of names", () => {
    for (const [path, text] of ofEnglish) {
      const names = (each: Text | undefined) => said(each).match(/NAME/g)?.length ?? 0;
      expect([path, names(ofGerman.get(path)) > 0]).toEqual([path, names(text) > 0]);
    }
  });

  it("has no English texts, except those that are the same", () => {
    const equal = ofEnglish.filter(([path, text]) => {
      const words = said(text);
      return /\p{L}{2,}/u.test(words) && words === said(ofGerman.get(path));
    });
    expect(equal.map(([path]) => path.slice(1)).sort()).toEqual(same);
  });
});

describe("parts", () => {
  it("are translated, whether they are loaded before or after the translation", async () => {
    vi.resetModules();
    const { part, translate } = await import("../../web/texts/part.ts");
    const before = part("help", { title: "Keys", rows: ["a"] });
    translate({ ...translation, help: { title: "Tasten" }, page: { reload: "Neu laden" } });
    const after = part("page", { reload: "Reload" });
    expect(before).toEqual({ title: "Tasten", rows: ["a"] });
    expect(after.reload).toBe("Neu laden");
  });
});

describe("languages", () => {
  afterEach(() => writeNumbersAs("en"));

  it("are chosen: the first known one of the browser's list", () => {
    expect(firstKnown(["fr-FR", "de-AT", "en"])).toBe("de");
    expect(firstKnown(["EN-gb", "de"])).toBe("en");
    expect(firstKnown(["fr", "", "constructor"])).toBeUndefined();
  });

  it("write numbers in a form that fields can read", () => {
    expect([formatValue(60.5), formatBytes(1234), listed(["1", "2"])]).toEqual([
      "60.5",
      "1.23 KB",
      "1, 2",
    ]);
    writeNumbersAs("de");
    expect([formatValue(-60.5), formatBytes(1234), listed(["1", "2"])]).toEqual([
      "-60,5",
      "1,23 KB",
      "1; 2",
    ]);
    for (const value of [0, 0.001, 60.5, -1000.5, 123456, 1.25e-7, 3e9]) {
      expect(parseValue(formatValue(value))).toBe(value);
    }
    expect(["en", "de", "de-CH"].map(decimalSignOf)).toEqual([".", ",", "."]);
  });

  it("have their own plurals", () => {
    const forms = { one: "one", few: "few", other: "other" };
    expect([1, 3, 5].map((n) => plurals("en")(n, forms))).toEqual(["one", "other", "other"]);
    expect([1, 3, 5].map((n) => plurals("pl")(n, forms))).toEqual(["one", "few", "other"]);
  });
});

describe("texts for visitors are in web/texts alone", () => {
  it("are found in templates, attributes and strings", () => {
    // biome-ignore-start lint/suspicious/noTemplateCurlyInString: it is a source
    const source = [
      'import a from "two words";',
      "html`<p class='no text'>Hello ${name}</p><b title=\"Read it\" id='x y'>${a > b ? c : d}</b>`;",
      "html`<a aria-label=${text}>${text}</a> % <!-- not read -->`;",
      'note("It did not work");',
      "note(`expected ${n} bytes`);",
      'button("Cancel", "wa-button", "ArrowLeft", "x", "px");',
      'a.className = "two words"; b = "one two".split(" ");',
    ].join("\n");
    // biome-ignore-end lint/suspicious/noTemplateCurlyInString: it is a source
    expect(visibleTexts("a.ts", source)).toEqual([
      { line: 2, text: "Read it" },
      { line: 2, text: "Hello …" },
      { line: 4, text: "It did not work" },
      { line: 5, text: "expected … bytes" },
      { line: 6, text: "Cancel" },
    ]);
  });

  const others = [
    // Names, which are the same in all languages.
    ...["Isosplat", "isosplat build VOLUME", "Full HD", "CSV", "JSON"],
    ...["Viridis", "Magma", "Cividis", "Turbo"],
    // Classes, properties, keys, headers, and a note that a store has.
    ...["icon-button minor", "surface active", "swatch chosen", "button play"],
    ...["chip choice", "chips choices"],
    ...["Home", "End", "Delete", "Enter", "Backspace", "Escape", "Files", "Authorization", "Range"],
    "left and right may be swapped",
    "(prefers-color-scheme: dark)",
    "found a text that begins with", // by which messages of the core are recognized
    // For programmers, whose language is English. The element shows messages of faults as they are.
    ...["index.html has no #page", "the page has no #page", "the dialog was closed"],
    "expected whole rows of … bytes, at most …, found … bytes",
    "expected … rows, found …",
    ...["a number above 0 and at most …", "one of …", "expected one of …, found …"],
    "expected a rate above 0 and at most …, found …",
    "nothing is drawn: the element is out of sight",
    "no volume is open",
    "the surface could not be drawn in time",
    ...['what show="…" names could not be loaded: …', "some of …"],
    "the renderer has not arrived for … s; still waiting for it",
    "the http or https address of a store",
    "the http or https address of a scene",
    "a whole number from 0",
    "16 numbers of an affine transform, row by row, the last row 0,0,0,1",
    "the layer … is missing: …",
    ...["the kernel's file", "the kernel's file: …", "expected … bytes, found …"],
    "expected an answer of the kernel within … s, found none",
    ...["a colour as rrggbb", "a finite number"],
    "There are no volumes here.", // of the element's example page
  ];

  const siteReadme = "A web site with one volume, from Isosplat. Unpack this archive";

  it("are nowhere else", () => {
    const folders = ["capture", "device", "element", "measure", "offline", "overlay", "page"];
    const files = trackedFiles(root, ...folders.map((folder) => `web/${folder}/*.ts`));
    expect(files.length).toBeGreaterThan(80);
    const found = files.flatMap((file) =>
      visibleTexts(file, readFileSync(join(root, file), "utf8")).map((each) => ({ ...each, file })),
    );
    const wrong = found.filter(
      ({ text }) => !others.includes(text) && !text.startsWith(siteReadme),
    );
    expect(wrong.map(({ file, line, text }) => `${file}:${line}: ${text}`)).toEqual([]);
    const idle = others.filter((text) => !found.some((each) => each.text === text));
    expect(idle).toEqual([]);
  });
});
