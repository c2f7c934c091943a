import { ArrayBufferTarget, Muxer } from "webm-muxer";
import { captureTexts } from "../texts/capture.ts";
import type { PictureSize } from "../viewer/types.ts";
import type { FilmFile } from "./film.ts";

/** Seconds between key frames. */
const keyFrameSeconds = 2;
/** The maximum number of frames that wait for the encoder. */
const mostWaiting = 4;
const bitsPerPixel = 0.12;

const codecs = [
  { name: "vp09.00.51.08", track: "V_VP9" },
  { name: "vp8", track: "V_VP8" },
] as const;

/** Bits per second. */
export function bitRate({ width, height }: PictureSize, framesPerSecond: number): number {
  return Math.max(1e6, Math.round(bitsPerPixel * width * height * framesPerSecond));
}

/** Whether this browser can encode videos. */
export function canEncode(): boolean {
  return typeof VideoEncoder !== "undefined";
}

/** A WebM file with VP9, or VP8. Rejects if the browser can encode neither at this size. */
export async function webmFile(size: PictureSize, framesPerSecond: number): Promise<FilmFile> {
  const { width, height } = size;
  for (const { name, track } of codecs) {
    const config: VideoEncoderConfig = {
      codec: name,
      width,
      height,
      bitrate: bitRate(size, framesPerSecond),
      framerate: framesPerSecond,
    };
    const { supported } = await VideoEncoder.isConfigSupported(config);
    if (!supported) continue;
    const target = new ArrayBufferTarget();
    const video = { codec: track, width, height, frameRate: framesPerSecond };
    return new WebmFile(config, new Muxer({ target, video }), target, framesPerSecond);
  }
  throw new Error(captureTexts.noVideo(width, height));
}

class WebmFile implements FilmFile {
  readonly #encoder: VideoEncoder;
  readonly #muxer: Muxer<ArrayBufferTarget>;
  readonly #target: ArrayBufferTarget;
  readonly #config: VideoEncoderConfig;
  readonly #framesPerSecond: number;
  #frames = 0;
  #failure: DOMException | undefined;

  constructor(
    config: VideoEncoderConfig,
    muxer: Muxer<ArrayBufferTarget>,
    target: ArrayBufferTarget,
    framesPerSecond: number,
  ) {
    this.#config = config;
    this.#muxer = muxer;
    this.#target = target;
    this.#framesPerSecond = framesPerSecond;
    this.#encoder = new VideoEncoder({
      output: (chunk, metadata) => muxer.addVideoChunk(chunk, metadata),
      error: (error) => {
        this.#failure = error;
      },
    });
    this.#encoder.configure(config);
  }

  async add(rgba: Uint8ClampedArray<ArrayBuffer>): Promise<void> {
    const { width, height } = this.#config;
    const frame = new VideoFrame(rgba, {
      format: "RGBX",
      codedWidth: width,
      codedHeight: height,
      timestamp: Math.round((this.#frames * 1e6) / this.#framesPerSecond),
      duration: Math.round(1e6 / this.#framesPerSecond),
    });
    const keyFrame = this.#frames % (keyFrameSeconds * this.#framesPerSecond) === 0;
    this.#encoder.encode(frame, { keyFrame });
    frame.close();
    this.#frames += 1;
    while (!this.#failure && this.#encoder.encodeQueueSize > mostWaiting) {
      await new Promise((resolve) => {
        this.#encoder.addEventListener("dequeue", resolve, { once: true });
      });
    }
    if (this.#failure) throw this.#failure;
  }

  async finish(): Promise<Blob> {
    await this.#encoder.flush();
    if (this.#failure) throw this.#failure;
    this.#muxer.finalize();
    return new Blob([this.#target.buffer], { type: "video/webm" });
  }

  close(): void {
    if (this.#encoder.state !== "closed") this.#encoder.close();
  }
}
