/** A viewer that draws nothing, and checks the guarantees of streaming. */
import { expect } from "vitest";
import { type Core, regionWords, visibilityWords } from "../../web/core/index.ts";
import {
  type CameraView,
  type ChunkPlace,
  InlineDecoder,
  type Progress,
  type Source,
  type StreamError,
  type StreamOptions,
  StreamSession,
} from "../../web/stream/index.ts";

/** A view of the fixture's volume from the front. distance: from its centre, in volume sizes. */
export function view(isovalue: number, distance = 1.5, size = 768): CameraView {
  const centre = [-10 + 74.5, 20 + 65, 30 + 51.75];
  const eye = distance * 150;
  const focal = 1 / Math.tan(((45 / 180) * Math.PI) / 2);
  const [near, far] = [1, 5000];
  // Columns of projection · view: x to the right, z up, looking along +y.
  const depth = (far + near) / (far - near);
  const shift = (2 * far * near) / (far - near);
  const [cx = 0, cy = 0, cz = 0] = centre;
  const y0 = cy - eye;
  return {
    viewProjection: [
      ...[focal, 0, 0, 0],
      ...[0, 0, depth, 1],
      ...[0, focal, 0, 0],
      ...[-focal * cx, -focal * cz, -depth * y0 - shift, -y0],
    ],
    viewport: { width: size, height: size },
    isovalues: [isovalue],
    moving: false,
  };
}

export class Harness {
  readonly resident = new Map<number, { place: ChunkPlace; samples: number }>();
  readonly uploaded = new Map<number, number>();
  /** As on the GPU: the samples of resident chunks, and the values of the field that is shown. */
  readonly samplesOf = new Map<number, Uint32Array>();
  readonly values = new Map<number, Uint32Array>();
  readonly errors: StreamError[] = [];
  readonly replacements: StreamError[] = [];
  /** Whether the viewer accepts a chunk. */
  takes: (id: number) => boolean = () => true;
  /** Whether the viewer answers occlusion queries: nothing is occluded. Set it before open(). */
  answersOcclusion = false;
  /** Occlusion queries that the session has made. */
  queries = 0;
  visible: number[] = [];
  progress: Progress | undefined;
  maxResident = 0;
  session: StreamSession | undefined;

  async open(
    source: Source,
    core: Core,
    options: Omit<StreamOptions, "events"> = {},
  ): Promise<StreamSession> {
    this.session = await StreamSession.open(source, core, {
      decoder: new InlineDecoder(core),
      // Only tests of the background loader set another value.
      backgroundBytes: 0,
      readAheadBytes: 0,
      ...options,
      events: {
        samples: (id, place, samples) => {
          if (!this.takes(id)) return false;
          expect(this.resident.has(id)).toBe(false);
          expect(samples.length % 4).toBe(0);
          this.resident.set(id, {
            place: { level: place.level, block: place.block },
            samples: samples.length / 4,
          });
          this.samplesOf.set(id, samples);
          this.uploaded.set(id, (this.uploaded.get(id) ?? 0) + 1);
          this.maxResident = Math.max(this.maxResident, this.samples);
          return true;
        },
        fieldValues: (id, values) => {
          expect(values.length).toBe(this.samplesOf.get(id)?.length);
          this.values.set(id, values);
        },
        readSamples: (id) => this.samplesOf.get(id)?.slice(),
        drop: (id) => {
          expect(this.resident.delete(id)).toBe(true);
          this.samplesOf.delete(id);
          this.values.delete(id);
          if (!this.closed) expect(this.visible).not.toContain(id);
        },
        visible: (ids, regions) => {
          expect(regions.length).toBe(regionWords * ids.length);
          for (const id of ids) expect(this.resident.has(id)).toBe(true);
          this.visible = [...ids];
        },
        progress: (progress) => {
          expect(this.closed).toBe(false);
          this.progress = progress;
        },
        error: (error) => {
          this.errors.push(error);
        },
        replaced: (error) => {
          this.replacements.push(error);
        },
        ...(this.answersOcclusion && { testOcclusion: () => this.#answerOcclusion() }),
      },
    });
    return this.session;
  }

  /** Answers as if the picture at rest were tested in the next frame. */
  #answerOcclusion(): void {
    setTimeout(() => {
      const query = this.session?.occlusionQuery(true);
      if (!query) return;
      ++this.queries;
      // For each chunk: its handle, the tested regions, and the visible ones.
      const answers = new Uint32Array(visibilityWords * query.ids.length).fill(~0);
      query.ids.forEach((id, i) => {
        answers[visibilityWords * i] = id;
      });
      this.session?.answerOcclusion(query, answers, true);
    });
  }

  closed = false;
  close(): void {
    this.closed = true;
    this.session?.close();
  }

  get samples(): number {
    return [...this.resident.values()].reduce((sum, { samples }) => sum + samples, 0);
  }

  /** Waits until a condition holds. */
  async until(what: () => boolean, milliseconds = 10_000): Promise<void> {
    const end = Date.now() + milliseconds;
    while (!what()) {
      if (Date.now() > end) {
        const errors = this.errors.map(({ message }) => message).join("; ");
        throw new Error(`waited in vain: ${JSON.stringify(this.progress)} ${errors}`);
      }
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
  }

  complete(): Promise<void> {
    return this.until(() => this.progress?.complete === true);
  }
}
