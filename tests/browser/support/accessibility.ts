import { readFileSync } from "node:fs";
import type { Page } from "@playwright/test";

/** Serious and critical findings of axe-core on the page as it is shown now. */
export async function findings(page: Page): Promise<string[]> {
  // The page's Content-Security-Policy allows no further script elements.
  await page.evaluate(readFileSync("node_modules/axe-core/axe.min.js", "utf8"));
  return page.evaluate(async () => {
    const { axe } = window as unknown as { axe: typeof import("axe-core") };
    const { violations } = await axe.run(document, { resultTypes: ["violations"] });
    return violations
      .filter(({ impact }) => impact === "serious" || impact === "critical")
      .flatMap(({ id, nodes }) => nodes.map(({ html }) => `${id}: ${html.slice(0, 200)}`));
  });
}
