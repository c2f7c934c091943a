/**
 * Writes web/element/REFERENCE.md from the comments and declarations of the elements' classes.
 *
 *     npm run reference            writes the file
 *     npm run reference -- --print prints it instead
 */
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("../..", import.meta.url));

/** The elements, and the files of their classes. */
const elements = {
  "isosplat-viewer": "isosplat_viewer.ts",
  "isosplat-layer": "isosplat_layer.ts",
};

/** The description of an element's class by the analyzer of custom elements. */
function declaration(name, source) {
  const folder = mkdtempSync(join(tmpdir(), "isosplat-reference-"));
  try {
    const analyzer = join(root, "node_modules/.bin/custom-elements-manifest");
    // Runs in a separate folder, since it writes the name of its output into the package.json there.
    copyFileSync(join(root, "web/element", source), join(folder, source));
    execFileSync(analyzer, ["analyze", "--quiet", "--globs", source, "--outdir", "."], {
      cwd: folder,
      stdio: ["ignore", "ignore", "inherit"],
    });
    const manifest = JSON.parse(readFileSync(join(folder, "custom-elements.json"), "utf8"));
    return manifest.modules[0].declarations.find(({ tagName }) => tagName === name);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

const cell = (text) => (text ?? "").replaceAll(/\s+/g, " ").replaceAll("|", "\\|").trim();
const code = (text) => `\`${cell(text)}\``;

function table(title, head, rows) {
  if (rows.length === 0) return [];
  const line = (cells) => `| ${cells.join(" | ")} |`;
  return [`### ${title}`, "", line(head), line(head.map(() => "---")), ...rows.map(line), ""];
}

function reference(element) {
  const described = element.members.filter(
    ({ description, privacy, inheritedFrom }) => description && !privacy && !inheritedFrom,
  );
  const fields = described.filter(({ kind, static: isStatic }) => kind === "field" && !isStatic);
  const methods = described.filter(({ kind }) => kind === "method");
  const signature = ({ name, parameters = [], return: result }) =>
    `${name}(${parameters.map((p) => p.name).join(", ")})${result ? `: ${result.type.text}` : ""}`;
  return [
    `## \`<${element.tagName}>\``,
    "",
    ...table(
      "Attributes",
      ["attribute", "type", ""],
      (element.attributes ?? [])
        .filter(({ description }) => description)
        .map(({ name, type, description }) => [code(name), type?.text ?? "", cell(description)]),
    ),
    ...table(
      "Properties",
      ["property", "type", ""],
      fields.map(({ name, type, readonly, description }) => [
        code(name),
        code(type?.text) + (readonly ? ", read only" : ""),
        cell(description),
      ]),
    ),
    ...table(
      "Methods",
      ["method", ""],
      methods.map((method) => [code(signature(method)), cell(method.description)]),
    ),
    ...table(
      "Events",
      ["event", "type", ""],
      (element.events ?? [])
        .filter(({ description }) => description)
        .map(({ name, type, description }) => [code(name), code(type?.text), cell(description)]),
    ),
    ...table(
      "Slots",
      ["slot", ""],
      (element.slots ?? []).map(({ name, description }) => [
        name ? code(name) : "",
        cell(description),
      ]),
    ),
    ...table(
      "CSS parts",
      ["part", ""],
      (element.cssParts ?? []).map(({ name, description }) => [code(name), cell(description)]),
    ),
    ...table(
      "CSS custom properties",
      ["property", ""],
      (element.cssProperties ?? []).map(({ name, description }) => [code(name), cell(description)]),
    ),
  ];
}

const text = [
  "# The elements: reference",
  "",
  "`npm run reference` writes this page from `web/element/isosplat_viewer.ts` and `isosplat_layer.ts`. [README](README.md) explains the elements.",
  "",
  ...Object.entries(elements).flatMap((element) => reference(declaration(...element))),
].join("\n");
if (process.argv.includes("--print")) process.stdout.write(text);
else writeFileSync(join(root, "web/element/REFERENCE.md"), text);
