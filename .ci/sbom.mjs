/**
 * Writes FOLDER/isosplat-VERSION.spdx.json, the list of components of the packages in FOLDER, in the
 * form of SPDX 2.3.
 *
 *     node .ci/sbom.mjs FOLDER [PAGE_PACKAGES]
 *
 * It has each package with its SHA-256; the Debian packages that it depends on, in the versions of this
 * machine; the header-only libraries that are compiled in; and the npm packages in the page, which the
 * build of the page lists in PAGE_PACKAGES (build/page.packages.json). SOURCE_DATE_EPOCH is the time in
 * it, or else that of the last commit, so that the same packages have the same list.
 */
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
const [folder, pagePackages = join(root, "build/page.packages.json")] = process.argv.slice(2);
if (!folder) throw new Error("expected a folder with packages: node .ci/sbom.mjs FOLDER");

const read = (file) => readFileSync(file, "utf8");
const run = (...command) =>
  execFileSync(command[0], command.slice(1), { encoding: "utf8", maxBuffer: 2 ** 26 }).trim();
const { version } = JSON.parse(read(join(root, "package.json")));
const lock = JSON.parse(read(join(root, "package-lock.json"))).packages;
const epoch = process.env.SOURCE_DATE_EPOCH ?? run("git", "-C", root, "log", "-1", "--format=%ct");

/** The Debian packages whose code is compiled into the programs and modules. */
const inModules = ["emscripten", "libexpected-dev", "libxxhash-dev", "nlohmann-json3-dev"];
const inProgram = [
  "libboost",
  "libcli11-dev",
  "libexpected-dev",
  "libxxhash-dev",
  "nlohmann-json3-dev",
];
const inPage = [...inModules, "libfmt-dev"];
const inLibrary = ["libxxhash-dev"];
const inModule = ["libexpected-dev", "libxxhash-dev", "nlohmann-json3-dev", "pybind11-dev"];

const isLicence = (text) => /^[\w.+-]+( (AND|OR|WITH) [\w.+-]+)*$/.test(text);
const table = run("bash", join(root, ".ci/install-packages"), "--table")
  .split("\n")
  .map((line) => line.split("|"))
  .map(([, names, , licence]) => ({
    names: names.split(",").map((name) => name.replace(/>=.*/, "")),
    licence: isLicence(licence) ? licence : "NOASSERTION",
  }));

/** Version and source package of each installed Debian package. */
const installed = new Map();
const fields = ["db:Status-Abbrev", "Package", "Version", "source:Package"];
const format = fields.map((field) => `$\{${field}}|`).join("");
for (const line of run("dpkg-query", "-W", "-f", `${format}\\n`).split("\n")) {
  const [status, name, found, source] = line.split("|");
  if (status.startsWith("ii")) installed.set(name, { version: found, source });
}
const licenceOfSource = new Map(
  table.flatMap(({ names, licence }) =>
    names.flatMap((name) => {
      const source = installed.get(name)?.source;
      return source ? [[source, licence]] : [];
    }),
  ),
);

const packages = new Map();
const relationships = [];
const relate = (from, relationshipType, to) =>
  relationships.push({ spdxElementId: from, relationshipType, relatedSpdxElement: to });

/** Adds a package once; returns its identifier. */
function add(kind, name, versionInfo, licenseDeclared, more = {}) {
  const SPDXID = `SPDXRef-${kind}-${name.replaceAll(/[^A-Za-z0-9.-]+/g, "-").replace(/^-/, "")}`;
  if (!packages.has(SPDXID)) {
    packages.set(SPDXID, {
      SPDXID,
      name,
      versionInfo,
      downloadLocation: "NOASSERTION",
      filesAnalyzed: false,
      licenseConcluded: "NOASSERTION",
      licenseDeclared,
      copyrightText: "NOASSERTION",
      ...more,
    });
  }
  return SPDXID;
}
const purl = (referenceLocator) => ({
  externalRefs: [{ referenceCategory: "PACKAGE-MANAGER", referenceType: "purl", referenceLocator }],
});

function addDebian(name) {
  const found = installed.get(name);
  if (!found) {
    throw new Error(`expected the Debian package ${name}, found none: .ci/setup release`);
  }
  const licence = licenceOfSource.get(found.source) ?? "NOASSERTION";
  const locator = `pkg:deb/debian/${encodeURIComponent(name)}@${encodeURIComponent(found.version)}`;
  return add("Debian", name, found.version, licence, purl(locator));
}
/** The first name of a line of .ci/install-packages that is installed. */
function addCompiledIn(first) {
  const line = table.find(({ names }) => names[0].startsWith(first));
  const name = line?.names.find((candidate) => installed.has(candidate)) ?? line?.names[0] ?? first;
  return addDebian(name);
}
function addNpm(name) {
  const entry = lock[`node_modules/${name}`];
  if (!entry) throw new Error(`expected ${name} in package-lock.json, found none: npm ci`);
  const licence = entry.license?.replace(/^\((.*)\)$/, "$1") ?? "NOASSERTION";
  const locator = `pkg:npm/${name.replace("@", "%40")}@${entry.version}`;
  return add("npm", name, entry.version, licence, purl(locator));
}

const files = readdirSync(folder)
  .filter((file) => /\.(deb|tgz|tar\.gz|whl)$/.test(file))
  .sort();
if (files.length === 0)
  throw new Error(`expected packages in ${folder}, found none: npm run release`);
const idOf = (file) => `SPDXRef-Package-${file.replaceAll(/[^A-Za-z0-9.-]+/g, "-")}`;
/** The Debian package of this name among the files. */
function addOwn(name) {
  const file = files.find((each) => each.startsWith(`${name}_`) && each.endsWith(".deb"));
  if (!file) throw new Error(`expected ${name}_VERSION.deb in ${folder}, found none`);
  return idOf(file);
}
const hashes = [];
for (const file of files) {
  const path = join(folder, file);
  const checksumValue = createHash("sha256").update(readFileSync(path)).digest("hex");
  hashes.push(checksumValue);
  const id = add("Package", file, version, "Apache-2.0", {
    packageFileName: file,
    checksums: [{ algorithm: "SHA256", checksumValue }],
  });
  relate("SPDXRef-DOCUMENT", "DESCRIBES", id);

  const isNpm = file.endsWith(".tgz");
  const isLibrary = file.startsWith("lib");
  const isPython = file.startsWith("python3-");
  const hasProgram = !isNpm && !isLibrary && !isPython;
  const compiledIn = new Set(isNpm ? inModules : isLibrary ? inLibrary : []);
  if (hasProgram) for (const name of [...inProgram, ...inPage]) compiledIn.add(name);
  if (isPython || /\.(whl|tar\.gz)$/.test(file)) for (const name of inModule) compiledIn.add(name);
  for (const name of compiledIn) relate(id, "CONTAINS", addCompiledIn(name));
  if (hasProgram) {
    for (const name of JSON.parse(read(pagePackages))) relate(id, "CONTAINS", addNpm(name));
  }
  if (file.endsWith(".deb")) {
    for (const [field, type] of [
      ["Depends", "DEPENDS_ON"],
      ["Recommends", "OPTIONAL_DEPENDENCY_OF"],
    ]) {
      for (const item of run("dpkg-deb", "--field", path, field).split(/\s*,\s*/)) {
        const [name] = item.split(/[ (|]/);
        if (!name) continue;
        const other = name === "isosplat" ? addOwn(name) : addDebian(name);
        if (type === "DEPENDS_ON") relate(id, type, other);
        else relate(other, type, id);
      }
    }
  }
}

// A UUID of the packages' content (version 8: of the maker's own form).
const digits = createHash("sha256").update(hashes.join("\n")).digest("hex");
const uuid = `${digits.slice(0, 8)}-${digits.slice(8, 12)}-8${digits.slice(13, 16)}-8${digits.slice(17, 20)}-${digits.slice(20, 32)}`;
const sbom = {
  spdxVersion: "SPDX-2.3",
  dataLicense: "CC0-1.0",
  SPDXID: "SPDXRef-DOCUMENT",
  name: `isosplat-${version}`,
  documentNamespace: `urn:uuid:${uuid}`,
  creationInfo: {
    created: new Date(1000 * Number(epoch)).toISOString().replace(/\.\d+Z$/, "Z"),
    creators: [`Tool: isosplat-sbom-${version}`],
  },
  packages: [...packages.values()],
  relationships,
};
writeFileSync(join(folder, `isosplat-${version}.spdx.json`), `${JSON.stringify(sbom, null, 2)}\n`);
