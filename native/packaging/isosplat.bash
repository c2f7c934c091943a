# Completion of isosplat for bash. Subcommands and options come from --help, so they are those of
# the installed program.
_isosplat() {
  local word=${COMP_WORDS[COMP_CWORD]} command='' i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    if [[ ${COMP_WORDS[i]} != -* ]]; then command=${COMP_WORDS[i]} && break; fi
  done
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("${COMP_WORDS[0]}" ${command:+"$command"} --help 2>/dev/null |
      grep -oE '(^|[ ,])--?[a-z][a-z-]*' | tr -d ' ,' | sort -u)" -- "$word")
  elif [[ -z $command ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$("${COMP_WORDS[0]}" --help 2>/dev/null |
      sed -n '/^[Ss]ubcommands:/,/^[^ ]/s/^  \([a-z-]*\) .*/\1/p')" -- "$word")
  else
    compopt -o default
  fi
}
complete -F _isosplat isosplat
