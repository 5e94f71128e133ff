# Turns text files into one C++ source of string views, so that the program needs no files beside it:
#   cmake -D OUTPUT=x.cpp -D HEADER=x.hpp -D "NAMES=a,b" -D "FILES=a.html,b.js" -P embed_files.cmake
# One raw string literal per file: GCC and Clang set no limit on its length.
string(REPLACE "," ";" NAMES "${NAMES}")
string(REPLACE "," ";" FILES "${FILES}")
set(source "#include \"${HEADER}\"\n\nnamespace struna::apps {\n\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ "${file}" text)
  string(FIND "${text}" ")struna_file\"" end)
  if(NOT end EQUAL -1)
    message(FATAL_ERROR "${file} holds the delimiter that would end its string literal")
  endif()
  string(APPEND source "static const char ${name}_text[] = R\"struna_file(${text})struna_file\";\n"
                       "const std::string_view ${name}{${name}_text, sizeof(${name}_text) - 1};\n\n")
endforeach()
file(WRITE "${OUTPUT}" "${source}}  // namespace struna::apps\n")
