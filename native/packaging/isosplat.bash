# Completion of isosplat for bash. It reads subcommands, options and their values from --help, so it
# fits the installed version of the program.
_isosplat() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command='' help i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    if [[ ${COMP_WORDS[i]} != -* ]]; then command=${COMP_WORDS[i]} && break; fi
  done
  help=$("${COMP_WORDS[0]}" ${command:+"$command"} --help 2>/dev/null)
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep -oE '(^|[ ,])--?[a-z][a-z-]*' <<<"$help" |
      tr -d ' ,' | sort -u)" -- "$word")
  elif [[ -z $command ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(sed -n '/^[Ss]ubcommands:/,/^[^ ]/s/^  \([a-z-]*\) .*/\1/p' \
      <<<"$help")" -- "$word")
  else
    # Finds the values that an option accepts: "  --kind TEXT:{quad,ellipse,exact} …".
    if [[ $before == -* ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$(sed -nE "s/^ +([^ ]*,)?${before}(,[^ ]*)? [A-Z]+:\{([^}]*)\}.*/\3/p" \
        <<<"$help" | tr , ' ')" -- "$word")
    fi
    if ((!${#COMPREPLY[@]})); then compopt -o default; fi
  fi
}
complete -F _isosplat isosplat
