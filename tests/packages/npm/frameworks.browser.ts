// The element in React, Vue and Svelte: the README's examples, built by Vite from the tarball.
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { build } from "vite";
import { type Nginx, nginx } from "../../support/nginx.ts";
import type { Consumer } from "./consumer.ts";
import { frameworkProject, frameworks, pageOf } from "./frameworks.ts";

/** A component that is removed and added again; StrictMode mounts it twice each time. */
const strict = `
import "isosplat/react";
import { StrictMode, useState } from "react";
import { createRoot } from "react-dom/client";

function View() {
  const [isShown, setShown] = useState(true);
  return (
    <>
      {isShown && <isosplat-viewer src="head.isosplat" isovalues={[60.5]} />}
      <button onClick={() => setShown(!isShown)}>Toggle</button>
    </>
  );
}

createRoot(document.getElementById("app")!).render(<StrictMode><View /></StrictMode>);
`;

let project: Consumer;
let server: Nginx;
const names = Object.keys(frameworks);

test.beforeAll(async () => {
  test.setTimeout(180_000);
  project = frameworkProject();
  project.write("strict.html", pageOf("strict.tsx"));
  project.write("strict.tsx", strict);
  const output = join(project.folder, "dist");
  await build({
    root: project.folder,
    configFile: join(project.folder, "vite.config.js"),
    logLevel: "warn",
    build: {
      outDir: output,
      rolldownOptions: {
        input: [...names, "strict"].map((name) => join(project.folder, `${name}.html`)),
      },
    },
  });
  // The store lies beside the pages.
  server = await nginx({ folders: [output, project.folder] });
});

test.afterAll(async () => {
  await server?.stop();
  project?.remove();
});

for (const name of names) {
  test(`${name}: the state changes the picture, and the picture the state`, async ({ page }) => {
    const found: string[] = [];
    page.on("pageerror", (error) => found.push(error.message));
    await page.goto(`${server.url}${name}.html`);
    const view = page.locator("isosplat-viewer");
    /** The isovalues that are drawn, once the picture is complete. */
    const drawn = () =>
      view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) =>
        e.progress?.complete ? e.viewer?.surfaces.map(({ isovalue }) => isovalue) : undefined,
      );
    await expect.poll(drawn).toEqual([60.5]);
    await page.getByRole("button", { name: "Higher" }).click();
    await expect.poll(drawn).toEqual([160.5]);
    await expect(page.locator("output")).toHaveText("160.5");

    const field = view.getByLabel("Isovalue as a number");
    await field.fill("300.5");
    await field.press("Enter");
    await expect(page.locator("output")).toHaveText("300.5");
    await expect.poll(drawn).toEqual([300.5]);
    expect(found).toEqual([]);
  });
}

test("react: an element that StrictMode mounts twice draws, and again after it was removed", async ({
  page,
}) => {
  const found: string[] = [];
  page.on("pageerror", (error) => found.push(error.message));
  await page.goto(`${server.url}strict.html`);
  const view = page.locator("isosplat-viewer");
  const isComplete = () =>
    view.evaluate((e: HTMLElementTagNameMap["isosplat-viewer"]) => e.progress?.complete ?? false);
  for (let round = 0; round < 2; ++round) {
    await expect.poll(isComplete).toBe(true);
    await expect(view).toHaveCount(1);
    await page.getByRole("button", { name: "Toggle" }).click();
    await expect(view).toHaveCount(0);
    await page.getByRole("button", { name: "Toggle" }).click();
  }
  expect(found).toEqual([]);
});
