/**
 * The options of isosplat build and isosplat extract that messages of the core name. Options of other programs
 * and of isosplat serve are left in messages.
 */
export const buildOptions = [
  ...["allow-frames", "allow-gaps", "allow-surplus", "allow-truncated", "allow-unplaced"],
  ...["channel", "dataset", "dims", "drop-displaced", "endian", "labels", "max-error", "memory"],
  ...["missing-value", "open", "segment", "series", "skip-bytes", "spacing", "time-step", "type"],
] as const;

/** Also with a value: "--missing-value=0". Not part of a file's name: "a --type.nrrd". */
const option = String.raw`--(?:${buildOptions.join("|")})(?:=\S+)?(?!\.?[\w-])`;
const anOption = new RegExp(String.raw`(?<![\w-])${option}`);
const command = /\bisosplat [a-z]+ --/;

/** Options in a sentence: "for --segment", "with --dims, --type and --spacing". */
const phrase = (() => {
  const each = String.raw`${option}(?: \d+)?`;
  return new RegExp(
    `,? (?:for|as|with) ${each}(?:(?:, | and | or | to )${each})*(?: requests)?`,
    "g",
  );
})();

/** What to do: "choose one with --dataset", "--missing-value none keeps them". */
const advice = (() => {
  const verbs =
    "accept|choose|correct|give(?! its)|ignore|increase|leave|raise|read|remove|set|use";
  const effects = "chooses|keeps|reads|removes|sets";
  return new RegExp(
    String.raw`^(?:or,? )?(?:if [^,]*, )?(?:(?:${verbs})\b|${option}(?: \S+){0,4} (?:${effects})\b)`,
  );
})();

/** Whether a clause names an option, and is no command of isosplat, which can be run elsewhere. */
const names = (clause: string) => anOption.test(clause) && !command.test(clause);

/**
 * A message without the options of isosplat build and extract, which nobody can give to the page: advice that
 * consists of them is left out, such as ", or read it with --allow-gaps", and elsewhere they lose their hyphens.
 * Never empty. For messages of the core and of the program, whose remedies are for both.
 */
export function withoutOptions(message: string): string {
  if (!anOption.test(message)) return message;
  const [, path = "", rest = message] = /^((?!--)[^:]*: )(.+)$/s.exec(message) ?? [];
  const hasPath = path !== "" && !/\b(?:expected|found)\b/.test(path);
  const [first = "", ...others] = (hasPath ? rest : message)
    .replace(/ \(([^()]*)\)/g, (inParentheses) => (names(inParentheses) ? "" : inParentheses))
    .split(/(; |: |, (?=or\b))/);
  let kept = (hasPath ? path : "") + inWords(first);
  /** The separator before clauses that were left out. */
  let left: string | undefined;
  for (let i = 0; i < others.length; i += 2) {
    const [separator = "", clause = ""] = others.slice(i, i + 2);
    const isOther = separator === ", " && left !== undefined;
    if (names(clause) && (isOther || advice.test(clause))) {
      left ??= separator;
    } else {
      kept += isOther ? `${left}${clause.replace(/^or,? /, "")}` : separator + inWords(clause);
      left = undefined;
    }
  }
  return kept;
}

/** Options in the middle of a sentence, as words: "a --time-step" is "a time step". */
function inWords(clause: string): string {
  if (!names(clause)) return clause;
  return clause
    .replace(phrase, "")
    .replace(new RegExp(anOption, "g"), (found) => found.replaceAll("-", " ").trim());
}

/** The message of an error, as the page shows it. */
export function messageOf(error: unknown): string {
  return withoutOptions(error instanceof Error ? error.message : String(error));
}
