# The shared library shows the functions of the header, all of them and nothing else.
execute_process(COMMAND ${NM} --dynamic --defined-only --format=posix ${LIBRARY}
  OUTPUT_VARIABLE shown COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" shown "${shown}")
list(TRANSFORM shown REPLACE " .*" "")
file(READ ${HEADER} header)
string(REGEX MATCHALL "holdfast_[a-z_]+\\(" declared "${header}")
# Comments name functions with an empty list of arguments too.
list(TRANSFORM declared REPLACE "\\(" "")
list(REMOVE_DUPLICATES declared)
list(SORT declared)
list(SORT shown)
if(NOT shown STREQUAL declared)
  message(FATAL_ERROR "the library shows\n  ${shown}\nthe header declares\n  ${declared}")
endif()
