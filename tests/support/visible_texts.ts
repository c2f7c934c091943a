import { parseSync, Visitor } from "vite";

/** A text in a source file that a visitor may read. */
export interface VisibleText {
  line: number;
  text: string;
}

/** Attributes whose values a visitor may read. */
const readAttributes =
  /\s(?:label|summary|title|alt|placeholder|hint|aria-(?:label|description|roledescription|valuetext))=(?:"([^"]*)"|'([^']*)')/g;

/** Placeholder for an expression in a template. */
const hole = "\u0001";

/**
 * The texts in TypeScript that a visitor may read: text and some attributes in html`…` and svg`…`.
 * Also any other string that has two words, or is one word with a capital letter.
 */
export function visibleTexts(file: string, source: string): VisibleText[] {
  const { program, errors } = parseSync(file, source, {});
  if (errors.length > 0) throw new Error(`${file}: ${errors[0]?.message}`);
  const found: VisibleText[] = [];
  const add = (start: number, text: string) => {
    // Markup, styles, selectors, addresses.
    if (/[{}<>[\]]|[:;][^\s“”]|px[,)]/.test(text)) return;
    const line = source.slice(0, start).split("\n").length;
    found.push({ line, text: text.replaceAll(hole, "…").replace(/\s+/g, " ").trim() });
  };
  const addString = (start: number, text: string) => {
    const words = text.replaceAll(hole, " ");
    if (
      /\p{L}{2,}[.,:;!?]? +\p{L}{2,}/u.test(words) ||
      /^\s*\p{Lu}\p{Ll}+[.:…]?\s*$/u.test(words)
    ) {
      add(start, text);
    }
  };
  /** Literals that visitors do not read, or that other code handles. */
  const others = new Set<unknown>();
  new Visitor({
    ImportDeclaration: (node) => void others.add(node.source),
    // Names in one string: "src link controls".split(" ").
    CallExpression({ callee }) {
      if (callee.type !== "MemberExpression" || callee.property.type !== "Identifier") return;
      if (callee.property.name === "split") others.add(callee.object);
    },
    AssignmentExpression({ left, right }) {
      if (left.type !== "MemberExpression" || left.property.type !== "Identifier") return;
      if (left.property.name === "className") others.add(right);
    },
    TaggedTemplateExpression({ tag, quasi, start }) {
      others.add(quasi);
      if (tag.type !== "Identifier" || !["html", "svg"].includes(tag.name)) return;
      const markup = quasi.quasis.map(({ value }) => value.raw).join(hole);
      const text = markup.replace(/<!--[\s\S]*?-->/g, "");
      for (const [, double, single] of text.matchAll(readAttributes)) {
        const value = double ?? single ?? "";
        if (/\p{L}{2,}/u.test(value)) add(start, value);
      }
      for (const part of text.replace(/<(?:"[^"]*"|'[^']*'|[^>"'])*>/g, "\n\n").split("\n\n")) {
        if (/\p{L}{2,}/u.test(part)) add(start, part);
      }
    },
    TemplateLiteral(node) {
      if (others.has(node)) return;
      addString(node.start, node.quasis.map(({ value }) => value.cooked ?? "").join(hole));
    },
    Literal(node) {
      if (typeof node.value === "string" && !others.has(node)) addString(node.start, node.value);
    },
  }).visit(program);
  return found;
}
