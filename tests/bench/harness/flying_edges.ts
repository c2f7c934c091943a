import { type ChildProcess, spawn } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { gunzipSync } from "node:zlib";
import { root } from "./paths.ts";
import { peakMegabytes } from "./peak_memory.ts";

/** A volume's unchanged values, little-endian, x fastest. */
export interface RawVolume {
  voxels: [number, number, number];
  type: "u8" | "i16" | "u16" | "f32";
  data: Buffer;
}

const types: Record<string, RawVolume["type"]> = {
  "unsigned char": "u8",
  uchar: "u8",
  uint8: "u8",
  short: "i16",
  int16: "i16",
  "unsigned short": "u16",
  ushort: "u16",
  uint16: "u16",
  float: "f32",
};

/** Reads an NRRD file, attached or detached, raw or gzip: enough for the benchmarks' inputs. */
export function readNrrd(path: string): RawVolume {
  const file = readFileSync(path);
  const blank = file.indexOf("\n\n");
  const header = file.subarray(0, blank < 0 ? file.length : blank).toString("latin1");
  const field = (name: string) =>
    header.match(new RegExp(`^${name}:[ \\t]*(.*?)\\r?$`, "mi"))?.[1] ?? "";
  const dataFile = field("data ?file");
  const bytes = dataFile ? readFileSync(join(dirname(path), dataFile)) : file.subarray(blank + 2);
  const type = types[field("type")];
  if (!type) throw new Error(`${path}: type "${field("type")}" is not one of the benchmarks'`);
  const data = /^gz/.test(field("encoding")) ? gunzipSync(bytes) : bytes;
  if (type !== "u8" && field("endian") === "big") data.swap16();
  return { voxels: field("sizes").split(/\s+/).map(Number) as RawVolume["voxels"], type, data };
}

/** The result of VTK's filter for one isovalue. */
export interface Mesh {
  seconds: number;
  triangles: number;
  points: number;
  /** Points, normals and connectivity. */
  bytes: number;
}

/** VTK's Flying Edges, or its marching cubes, in a separate process, with the volume loaded. */
export class FlyingEdges {
  readonly #child: ChildProcess;
  readonly #lines: AsyncIterator<string>;

  private constructor(child: ChildProcess) {
    this.#child = child;
    if (!child.stdout) throw new Error("no pipe to VTK");
    this.#lines = createInterface({ input: child.stdout })[Symbol.asyncIterator]();
  }

  /** `python`: Bench.pythonWithVtk(); `folder`: for the volume's values as a raw file. */
  static async open(
    python: string,
    volume: RawVolume,
    threads: number,
    folder: string,
    filter: "flying-edges" | "marching-cubes" = "flying-edges",
  ): Promise<FlyingEdges> {
    const raw = join(folder, `${filter}.raw`);
    writeFileSync(raw, volume.data);
    const script = join(root, "tests/evidence/peers/flying_edges.py");
    const args = [script, raw, ...volume.voxels.map(String), volume.type, String(threads)];
    if (filter === "marching-cubes") args.push(filter);
    const peer = new FlyingEdges(spawn(python, args, { stdio: ["pipe", "pipe", "inherit"] }));
    const { backend } = (await peer.#answer()) as { backend: string };
    if (backend !== "TBB") throw new Error(`VTK runs on ${backend}, not TBB: not the peer to beat`);
    return peer;
  }

  get peakMegabytes(): number {
    return peakMegabytes(this.#child.pid);
  }

  async extract(isovalue: number): Promise<Mesh> {
    this.#child.stdin?.write(`${isovalue}\n`);
    return (await this.#answer()) as Mesh;
  }

  close(): void {
    this.#child.kill();
  }

  async #answer(): Promise<unknown> {
    const { value, done } = await this.#lines.next();
    if (done) throw new Error("VTK ended");
    return JSON.parse(value);
  }
}
