// Tests real volumes end to end: the program builds them, the server serves them, and the page
// draws them. Skipped if the folder of volumes (ISOSPLAT_VOLUMES, ../shared/volumes) does not
// exist.
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "@playwright/test";
import { volumesFolder } from "../bench/harness/volumes.ts";
import { program, type RunningServer, serve } from "./support/server.ts";
import { compare, complete, savedPicture, settled } from "./support/view.ts";

/** Each format, and each kind of grid. truth.browser.ts opens further ones. */
const volumes = [
  { name: "fuel", file: "fuel.nhdr" },
  { name: "lobster", file: "lobster.nhdr" },
  { name: "mni152", file: "mni152.nii.gz" },
  { name: "ct_shear", file: "ct_shear.nii.gz" },
  // Vessels, with 0.4 million samples. The suggested isovalue shows noise: a software renderer
  // takes more than a minute to draw its millions of samples.
  { name: "mr_t1_dicom", file: "mr_t1_dicom", isovalue: 82.5 },
  { name: "cthead_tif", file: "cthead_tif", options: ["--spacing", "1,1,2"] },
  { name: "iron_protein", file: "iron_protein.vtk" },
  { name: "fetal_atlas_f32", file: "fetal_atlas_f32.nrrd" },
];

test.skip(!existsSync(volumesFolder), `no real volumes in ${volumesFolder}`);
test.use({ viewport: { width: 800, height: 480 } });

let folder: string;
let server: RunningServer;
test.beforeAll(async () => {
  test.setTimeout(300_000);
  folder = mkdtempSync(join(tmpdir(), "isosplat-volumes-"));
  for (const { name, file, options = [] } of volumes) {
    const store = join(folder, `${name}.isosplat`);
    execFileSync(program, ["build", join(volumesFolder, file), "-o", store, ...options], {
      stdio: "pipe",
    });
  }
  server = await serve([folder]);
});
test.afterAll(async () => {
  await server?.stop();
  if (folder) rmSync(folder, { recursive: true });
});

for (const { name, isovalue } of volumes) {
  test(`${name} opens`, { tag: "@slow" }, async ({ page }) => {
    test.setTimeout(240_000);
    const problems: string[] = [];
    page.on("pageerror", (error) => problems.push(String(error)));
    const shown = isovalue === undefined ? "" : `&isovalue=${isovalue}`;
    await page.goto(`${server.url}?volume=${name}${shown}&kind=ellipse&background=ffffff`);
    await complete(page, 200_000);
    await settled(page);
    const picture = await savedPicture(page);
    const { covered } = await compare(page, picture, picture);
    expect(covered).toBeGreaterThan(0.01);
    expect(problems).toEqual([]);
  });
}
