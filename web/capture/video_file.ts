import { Muxer as Mp4Muxer, ArrayBufferTarget as Mp4Target } from "mp4-muxer";
import { Muxer as WebmMuxer, ArrayBufferTarget as WebmTarget } from "webm-muxer";
import { captureTexts } from "../texts/capture.ts";
import type { PictureSize } from "../viewer/types.ts";
import type { FilmFile } from "./film.ts";
import { bitRate } from "./video_rate.ts";

/** Seconds between key frames. */
const keyFrameSeconds = 2;
/** The maximum number of frames that wait for the encoder. */
const mostWaiting = 4;

export type VideoFormat = keyof typeof containers;

/** A container that encoded frames are added to. */
interface Container {
  add(chunk: EncodedVideoChunk, metadata?: EncodedVideoChunkMetadata): void;
  finish(): ArrayBuffer;
}

/** The codecs of each format, best first. Levels of H.264 limit the size: 4K, Full HD, 720p. */
const containers = {
  webm: {
    type: "video/webm",
    codecs: [
      { name: "vp09.00.51.08", track: "V_VP9" },
      { name: "vp8", track: "V_VP8" },
    ],
    open: webm,
  },
  mp4: {
    type: "video/mp4",
    codecs: [
      { name: "avc1.640033", track: "avc" },
      { name: "avc1.640028", track: "avc" },
      { name: "avc1.42e01f", track: "avc" },
    ],
    open: mp4,
  },
} as const;

interface Track extends PictureSize {
  codec: string;
  frameRate: number;
}

function webm(video: Track): Container {
  const target = new WebmTarget();
  const muxer = new WebmMuxer({ target, video });
  return {
    add: (chunk, metadata) => muxer.addVideoChunk(chunk, metadata),
    finish: () => {
      muxer.finalize();
      return target.buffer;
    },
  };
}

function mp4(video: Track): Container {
  const target = new Mp4Target();
  const muxer = new Mp4Muxer({
    target,
    video: { ...video, codec: "avc" },
    fastStart: "in-memory",
  });
  return {
    add: (chunk, metadata) => muxer.addVideoChunk(chunk, metadata),
    finish: () => {
      muxer.finalize();
      return target.buffer;
    },
  };
}

/** A video. Rejects if the browser can encode none of the format's codecs at this size. */
export async function videoFile(
  format: VideoFormat,
  size: PictureSize,
  framesPerSecond: number,
): Promise<FilmFile> {
  const { width, height } = size;
  const { codecs, open, type } = containers[format];
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
    const container = open({ codec: track, width, height, frameRate: framesPerSecond });
    return new VideoFile(config, container, type, framesPerSecond);
  }
  throw new Error(captureTexts.noVideo(width, height));
}

class VideoFile implements FilmFile {
  readonly #encoder: VideoEncoder;
  readonly #container: Container;
  readonly #type: string;
  readonly #config: VideoEncoderConfig;
  readonly #framesPerSecond: number;
  #frames = 0;
  #failure: DOMException | undefined;

  constructor(
    config: VideoEncoderConfig,
    container: Container,
    type: string,
    framesPerSecond: number,
  ) {
    this.#config = config;
    this.#container = container;
    this.#type = type;
    this.#framesPerSecond = framesPerSecond;
    this.#encoder = new VideoEncoder({
      output: (chunk, metadata) => container.add(chunk, metadata),
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
    return new Blob([this.#container.finish()], { type: this.#type });
  }

  close(): void {
    if (this.#encoder.state !== "closed") this.#encoder.close();
  }
}
