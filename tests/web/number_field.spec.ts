// Number fields of dialogs: the decimal sign does not depend on the browser's language.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { afterEach, expect, it } from "vitest";
import { numberField } from "../../web/page/shell/number_field.ts";
import { writeNumbersAs } from "../../web/texts/numbers.ts";
import { trackedFiles } from "../support/source_graph.ts";

const root = fileURLToPath(new URL("../..", import.meta.url));

afterEach(() => writeNumbersAs("en"));

/** The text of a new field, and the number that it reports when a text is typed. */
function fieldOf(value: number): { shown: unknown; typed: (text: string) => number } {
  let entered = 0;
  const { values } = numberField("Along x", value, (number) => {
    entered = number;
  });
  const listener = values.find((each) => typeof each === "function") as (event: object) => void;
  const typed = (text: string) => {
    listener({ currentTarget: { value: text } });
    return entered;
  };
  return { shown: values[2], typed };
}

it.each(["en", "de"])("reads a decimal comma and a decimal point in a page in %s", (language) => {
  writeNumbersAs(language);
  const { typed } = fieldOf(1);
  expect(["0,25", "0.25", "1,", "1e-3", "1.024,5", "", "x", "1,2,3"].map(typed)).toEqual([
    0.25,
    0.25,
    1,
    1e-3,
    1024.5,
    NaN,
    NaN,
    NaN,
  ]);
});

it("shows its number as the page's language writes it", () => {
  expect(fieldOf(0.25).shown).toBe("0.25");
  writeNumbersAs("de");
  expect([0.25, 5e-7, NaN].map((value) => fieldOf(value).shown)).toEqual(["0,25", "5e-7", ""]);
});

it("is used for all numbers: no field of the page follows the browser's language", () => {
  const files = trackedFiles(root, "web/page/*.ts", "web/element/*.ts");
  expect(files.length).toBeGreaterThan(50);
  const wrong = files.filter((file) =>
    /type="number"/.test(readFileSync(join(root, file), "utf8")),
  );
  expect(wrong).toEqual([]);
});
