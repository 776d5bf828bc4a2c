# cmake -DOUTPUT=file.cpp -DINPUTS=a;b -P EmbedText.cmake: a C++ source that holds text files as string literals,
# looked up by file name with holdfast::embedded_text().
string(REPLACE "," ";" INPUTS "${INPUTS}")
set(body "#include \"embedded_text.hpp\"\n\nnamespace holdfast {\n\nstd::string_view embedded_text([[maybe_unused]] std::string_view name) {\n")
foreach(input ${INPUTS})
  get_filename_component(name ${input} NAME)
  file(READ ${input} text)
  string(APPEND body "  if (name == \"${name}\") {\n    return R\"__text__(${text})__text__\";\n  }\n")
endforeach()
string(APPEND body "  return {};\n}\n\n}  // namespace holdfast\n")
file(WRITE ${OUTPUT} "${body}")
