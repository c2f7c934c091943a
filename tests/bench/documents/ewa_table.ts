/** Alias and blur of splats and of an EWA resampling filter: rows of tests/bench/results/ewa.csv. */
import { readResults } from "../harness/table.ts";
import { markdown } from "./markdown.ts";

const bands = ["0.1", "0.2", "0.3", "0.4"];
const scenes = ["checker", "engine 60.5 whole", "engine 60.5 close up"];
const edges = ["edge width, cells of 8 px", "edge width, cells of 0.5 px"];

/** One row for each method of drawing, in the order in which they were measured. */
export function ewaTable(): string {
  const rows = readResults("ewa");
  const value = (scene: string, way: string, measure: string, digits: number) =>
    rows
      .find((row) => row.case === `${scene}, ${way}` && row.measure === measure)
      ?.median.toFixed(digits) ?? "";
  const ways = new Set(
    rows
      .filter((row) => row.case.startsWith("checker, ") && row.measure === "alias")
      .map((row) => row.case.slice("checker, ".length)),
  );
  const headings = [
    "drawn as",
    ...scenes.flatMap((scene) => [`${scene}: alias, %`, "contrast"]),
    "edge, px: cells of 8 px; of 0.5 px",
  ];
  const line = (way: string) => [
    way,
    ...scenes.flatMap((scene) => [
      value(scene, way, "alias", 1),
      bands.map((band) => value(scene, way, `contrast at ${band} cycles per px`, 2)).join(", "),
    ]),
    edges.map((edge) => value("checker", way, edge, 1)).join("; "),
  ];
  return markdown([headings, headings.map(() => "---"), ...[...ways].map(line)]);
}
