import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { program } from "./server.ts";

export interface NativeView {
  isovalue: number;
  /** As in the page's address. */
  camera: string;
  projection?: string;
  kind: "quad" | "ellipse" | "exact";
  width: number;
  height: number;
  /** Settings of the light by their parameters in the page's address. */
  light?: Readonly<Record<string, string>>;
}

/** Runs `isosplat render` for level 0, on white, in the page's first colour: a PNG. */
export function drawNatively(store: string, view: NativeView): Buffer {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-picture-"));
  try {
    const output = join(folder, "native.png");
    execFileSync(program, [
      ...["render", store, "--isovalue", String(view.isovalue), "-o", output, "--level", "0"],
      ...(view.projection ? ["--projection", view.projection] : []),
      ...["--size", `${view.width}x${view.height}`, "--camera", view.camera],
      ...["--kind", view.kind, "--background", "ffffff", "--colour", "d9ccb3"],
      ...Object.entries(view.light ?? {}).flatMap(([name, value]) => [
        name === "shade" ? "--eye-dome" : `--${name}`,
        value,
      ]),
    ]);
    return readFileSync(output);
  } finally {
    rmSync(folder, { recursive: true });
  }
}
