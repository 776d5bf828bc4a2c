#!/bin/sh
# build.sh PYTHON PACKAGE OUT: builds the site OUT/site of README, docs/, the C++ interface (Doxygen) and the Python
# package (pdoc; PACKAGE is the folder that holds it). Fails on any warning and on any link that leads nowhere.
set -eu
python=$1 package=$2 out=$3
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
mkdir -p "$out"
out=$(cd "$out" && pwd)
tree=$out/pages site=$out/site
rm -rf "$tree" "$site"
mkdir -p "$tree"

# The pages as they lie in the repository; files that they link to lie beside them. The README comes first.
cp -r "$root/docs" "$tree"
for name in LICENSE apps tests; do ln -s "$root/$name" "$tree/$name"; done
"$python" -m nbconvert --to markdown --log-level WARN "$tree/docs/guide/demo.ipynb"
find "$tree/docs" -name '*.md' -exec sed -i 's,(demo\.ipynb),(demo.md),' {} +
cat >"$tree/docs/interfaces.md" <<'PAGE'
# Interfaces

- <a href="../cpp/annotated.html">C++ and C</a>
- <a href="../python/holdfast.html">Python</a>
PAGE
{
  sed 's,docs/guide/demo\.ipynb,docs/guide/demo.md,' "$root/README.md"
  printf '\n```{toctree}\n:hidden:\n:caption: %s\n\n' Guide
  for page in model camera first_pose plain_objects results lost speed python demo embedding many_recordings; do
    echo "docs/guide/$page"
  done
  printf '```\n\n```{toctree}\n:hidden:\n:caption: Reference\n\n'
  printf 'docs/%s\n' reference/files reference/options reference/exit_codes reference/model_formats reference/systems interfaces architecture math
  printf '```\n\n```{toctree}\n:hidden:\n:caption: Results\n\n'
  printf 'docs/results/%s\n' rbot modalities experiments robustness recovery starts hazards performance devices
  printf '```\n'
} >"$tree/index.md"
"$python" -m sphinx -q -W --keep-going -c "$here" "$tree" "$site"

{ cat "$here/Doxyfile" && echo "OUTPUT_DIRECTORY = $site"; } | (cd "$root" && doxygen -)
MPLBACKEND=Agg "$python" -W error::UserWarning "$here/python_pages.py" "$package" "$site/python"
"$python" "$here/check_links.py" "$site"
rm -rf "$site/.doctrees" "$site/.buildinfo"
echo "docs: $site/index.html"
