#compdef isosplat
# Completion of isosplat for zsh. It reads subcommands, options and their values from --help, so it
# fits the installed version of the program.
local command before help
local -a names
command=${${words[2,CURRENT-1]:#-*}[1]}
before=${words[CURRENT-1]}
help=$(isosplat $command --help 2>/dev/null)
if [[ $PREFIX == -* ]]; then
  names=(${(f)"$(grep -oE '(^|[ ,])--?[a-z][a-z-]*' <<<$help | tr -d ' ,')"})
  compadd -- $names
elif [[ -z $command ]]; then
  names=(${(f)"$(sed -n '/^[Ss]ubcommands:/,/^[^ ]/s/^  \([a-z-]*\) .*/\1/p' <<<$help)"})
  compadd -- $names
else
  # Finds the values that an option accepts: "  --kind TEXT:{quad,ellipse,exact} …".
  if [[ $before == -* ]]; then
    names=(${(s:,:)"$(sed -nE "s/^ +([^ ]*,)?${before}(,[^ ]*)? [A-Z]+:\{([^}]*)\}.*/\3/p" <<<$help)"})
  fi
  if (($#names)); then compadd -- $names; else _files; fi
fi
