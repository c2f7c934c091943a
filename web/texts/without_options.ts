/** An option of the program isosplat, such as "--allow-gaps". */
const option = /(?<![\w-])--[a-z]/;

/**
 * A message without the options of the command line, which nobody can give to the page: the clauses that
 * name options are left out, such as ", or read it with --allow-gaps". For messages of the core and of the
 * program, whose remedies are for both.
 */
export function withoutOptions(message: string): string {
  if (!option.test(message)) return message;
  const kept = message
    .replace(/ ?\(([^()]*)\)/g, (inParentheses) =>
      option.test(inParentheses) ? "" : inParentheses,
    )
    .split(/(?=; |: |, | \(|\. |\.$)/)
    .filter((clause) => !option.test(clause))
    .join("")
    .replace(/^[;:,.\s]+|[;:,(\s]+$/g, "");
  return kept;
}

/** The message of an error, as the page shows it. */
export function messageOf(error: unknown): string {
  return withoutOptions(error instanceof Error ? error.message : String(error));
}
