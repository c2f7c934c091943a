#compdef isosplat
# Completion of isosplat for zsh. Subcommands, options and their values come from --help, so they are
# those of the installed program.
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
  # "  --kind TEXT:{quad,ellipse,exact} …": the values that an option accepts.
  if [[ $before == -* ]]; then
    names=(${(s:,:)"$(sed -nE "s/^ +([^ ]*,)?${before}(,[^ ]*)? [A-Z]+:\{([^}]*)\}.*/\3/p" <<<$help)"})
  fi
  if (($#names)); then compadd -- $names; else _files; fi
fi
