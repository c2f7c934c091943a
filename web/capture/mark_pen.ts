/** Characters that no document of XML may have, not even escaped. */
const notOfXml = /[^\t\n\r\u{20}-\u{d7ff}\u{e000}-\u{fffd}\u{10000}-\u{10ffff}]/gu;

/** Writes letters and lines as SVG, in a colour that can be read on the background, with a halo. */
export class MarkPen {
  /** The height of a line of text, in pixels of the picture. */
  readonly letter: number;
  readonly ink: string;
  readonly halo: string;

  /** `background`: #rrggbb; undefined: white. */
  constructor(letter: number, background: string | undefined) {
    this.letter = letter;
    const isDark = luminance(background ?? "#ffffff") < 128;
    this.ink = isDark ? "#f4f4f4" : "#1a1a1a";
    this.halo = isDark ? "#101010" : "#ffffff";
  }

  /** `size`: relative to `letter`. */
  text(
    content: string,
    x: number,
    y: number,
    { size = 1, anchor = "start" }: { size?: number; anchor?: "start" | "middle" | "end" } = {},
  ): string {
    const pixels = size * this.letter;
    const escaped = content
      .replace(notOfXml, "")
      .replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);
    return `<text x="${round(x)}" y="${round(y)}" font-size="${round(pixels)}" text-anchor="${anchor}" paint-order="stroke" stroke="${this.halo}" stroke-width="${round(0.22 * pixels)}" stroke-linejoin="round">${escaped}</text>`;
  }

  /** `path`: as in the attribute d. */
  line(path: string): string {
    const width = 0.12 * this.letter;
    const stroke = (colour: string, times: number) =>
      `<path d="${path}" fill="none" stroke="${colour}" stroke-width="${round(times * width)}"/>`;
    return stroke(this.halo, 2.6) + stroke(this.ink, 1);
  }
}

/** Of 0 … 255. */
function luminance(colour: string): number {
  const digits = /^#(..)(..)(..)/.exec(colour)?.slice(1) ?? [];
  const [red = 255, green = 255, blue = 255] = digits.map((hex) => Number.parseInt(hex, 16));
  return 0.3 * red + 0.59 * green + 0.11 * blue;
}

/** Hundredths of a pixel are enough. */
export function round(value: number): string {
  return String(Number(value.toFixed(2)));
}
