#!/bin/sh
# Fails when a real-time archive refers to the heap, to exceptions or RTTI, to stdio, or to a call that waits.
# Undefined symbols of one archive that another one of them defines are fine; they are checked there.
forbidden='^(malloc|calloc|realloc|free|aligned_alloc|posix_memalign|_Zn[wa]|_Zd[la]|__cxa_|_ZSt|_ZTI|_ZTVN10__cxxabi|_Unwind|__gxx_personality|printf|fprintf|puts|fopen|fwrite|pthread_|sleep|usleep|nanosleep|poll|select|read|write|system|exit|abort)'
bad=0
for archive in "$@"; do
  [ -s "$archive" ] || { echo "no archive: $archive"; exit 2; }
  hits=$(nm -u "$archive" | awk '$1 == "U" {print $2}' | grep -E "$forbidden" | sort -u)
  if [ -n "$hits" ]; then
    echo "$archive refers to:"
    echo "$hits" | c++filt | sed 's/^/  /'
    bad=1
  fi
done
exit $bad
