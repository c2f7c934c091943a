/** How the language of the page writes numbers. */

let decimalSign = ".";
let numbersLanguage = "en";

export function decimalSignOf(language: string): string {
  const parts = new Intl.NumberFormat(language).formatToParts(0.5);
  return parts.find(({ type }) => type === "decimal")?.value ?? ".";
}

export function writeNumbersAs(language: string): void {
  decimalSign = decimalSignOf(language);
  numbersLanguage = language;
}

/** A number that is written with a decimal point, as the page's language writes it: "60,5 mm". */
export function localized(number: string): string {
  return number.replace(".", decimalSign);
}

/** A number with its digits in groups, as the page's language writes it: "1,482". */
export function grouped(number: number): string {
  return number.toLocaleString(numbersLanguage, { maximumFractionDigits: 20 });
}

/** Numbers as a list: "0.5, 1", and where the comma is the decimal sign, "0,5; 1". */
export function listed(numbers: readonly string[]): string {
  return numbers.join(decimalSign === "," ? "; " : ", ");
}

type Forms = Partial<Record<Intl.LDMLPluralRule, string>> & { other: string };

/** Returns a function that chooses the singular or plural form of a text in a language. */
export function plurals(language: string): (n: number, forms: Forms) => string {
  const rules = new Intl.PluralRules(language);
  return (n, forms) => forms[rules.select(n)] ?? forms.other;
}
