import { expect, test } from "vitest";
import type { Progress } from "../../web/stream/index.ts";
import { openingProgress } from "../../web/viewer/layers_progress.ts";
import { PictureProgress } from "../../web/viewer/picture_progress.ts";

test("changes of several layers are pending until they are reported, once", async () => {
  const entries = [1, 2].map(() => ({
    layer: { visible: true },
    volume: { progress: openingProgress, error: null },
  }));
  const reports: Progress[] = [];
  const progress = new PictureProgress(
    { entries } as unknown as ConstructorParameters<typeof PictureProgress>[0],
    { samples: 1000 } as ConstructorParameters<typeof PictureProgress>[1],
    (report) => reports.push(report),
  );
  expect(progress.isPending).toBe(false);
  progress.layerChanged();
  progress.layerChanged();
  expect(progress.isPending).toBe(true);
  expect(reports).toEqual([]);
  await expect.poll(() => reports.length).toBe(1);
  expect(progress.isPending).toBe(false);
  expect(reports[0]?.state).toBe("opening");
});
