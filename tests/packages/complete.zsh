#!/usr/bin/env zsh
# complete.zsh FOLDER: types words and a tab into an interactive zsh that finds _isosplat in FOLDER
# and isosplat on PATH, and compares the line that results.
zmodload zsh/zpty
work=$(mktemp -d)
export ZDOTDIR=$work TERM=dumb
: >$work/head.nii.gz
# After the tab, the key ^X writes the line to a file and ends the shell.
cat >$work/.zshrc <<EOF
cd $work
fpath=(${(q)1} \$fpath)
autoload -Uz compinit && compinit -u -D
write_line() { print -r -- "\$BUFFER" >$work/line; exit }
zle -N write_line
bindkey '^I' complete-word
bindkey '^X' write_line
PS1='ready> '
EOF

failed=0
# completes TYPED EXPECTED: the line after a tab.
completes() {
  local output line
  rm -f $work/line
  zpty shell zsh -o no_global_rcs -i
  zpty -r shell output '*ready> *'
  zpty -w -n shell "$1"$'\t'
  zpty -w -n shell $'\x18'
  while zpty -r shell output 2>/dev/null; do done
  zpty -d shell
  line=$(<$work/line)
  if [[ $line != "$2" ]]; then
    print -r -- "'$1' and a tab: expected '$2', found '$line'"
    failed=1
  fi
}

completes 'isosplat ser' 'isosplat serve '
completes 'isosplat serve --por' 'isosplat serve --port '
completes 'isosplat extract --isov' 'isosplat extract --isovalue '
completes 'isosplat build hea' 'isosplat build head.nii.gz '
completes 'isosplat render --kind ell' 'isosplat render --kind ellipse '
completes 'isosplat render -o hea' 'isosplat render -o head.nii.gz '
rm -r $work
exit $failed
