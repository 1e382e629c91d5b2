# tessera_format(NAME ENDINGS .a .b [NAMES_OTHERS] [HAS_LEVELS] [USES ...] [PRIVATE ...]): a format of files that are volumes by themselves, as a
# room. Its folder, bricking/import/files/NAME, defines `FileFormat NAMEFormat()` (file_format.h) and calls this in a
# CMakeLists.txt: that is all that a format takes.
#   ENDINGS  of its files' names, in lower case; a name belongs to the format whose ending is the longest
#   HAS_LEVELS  its files may have their volume at several resolutions (FileFormat::hasLevels)
#   NAMES_OTHERS  its files may name others, which hold the voxels (FileFormat::parts)
function(tessera_format name)
  cmake_parse_arguments(ARG "NAMES_OTHERS;HAS_LEVELS" "" "ENDINGS;USES;PRIVATE" ${ARGN})
  tessera_room(tessera_format_${name} FOLDER bricking/import/files/${name}
    USES tessera_files ${ARG_USES}
    PRIVATE ${ARG_PRIVATE})
  set_property(GLOBAL APPEND PROPERTY TESSERA_FORMATS ${name})
  set_property(GLOBAL PROPERTY TESSERA_ENDINGS_OF_${name} ${ARG_ENDINGS})
  if(ARG_NAMES_OTHERS)
    set_property(GLOBAL APPEND PROPERTY TESSERA_NAMING_ENDINGS ${ARG_ENDINGS})
  endif()
  if(ARG_HAS_LEVELS)
    set_property(GLOBAL APPEND PROPERTY TESSERA_LEVELLED_ENDINGS ${ARG_ENDINGS})
  endif()
endfunction()

# tessera_format_endings(FILE): writes the source of format_endings.h.
function(tessera_format_endings file)
  get_property(formats GLOBAL PROPERTY TESSERA_FORMATS)
  set(all "")
  foreach(format IN LISTS formats)
    get_property(endings GLOBAL PROPERTY TESSERA_ENDINGS_OF_${format})
    list(APPEND all ${endings})
  endforeach()
  get_property(naming GLOBAL PROPERTY TESSERA_NAMING_ENDINGS)
  get_property(levelled GLOBAL PROPERTY TESSERA_LEVELLED_ENDINGS)
  foreach(list IN ITEMS all naming levelled)
    list(TRANSFORM ${list} REPLACE "(.+)" "\"\\1\"")
    list(JOIN ${list} ", " ${list})
  endforeach()
  file(CONFIGURE OUTPUT ${file} CONTENT [[
#include "bricking/import/source/format_endings.h"
namespace tessera {
const std::vector<std::string>& volumeFileEndings() {
    static const std::vector<std::string> endings = {@all@};
    return endings;
}
const std::vector<std::string>& namingFileEndings() {
    static const std::vector<std::string> endings = {@naming@};
    return endings;
}
const std::vector<std::string>& levelledFileEndings() {
    static const std::vector<std::string> endings = {@levelled@};
    return endings;
}
} // namespace tessera
]] @ONLY)
endfunction()

# tessera_format_table(FILE): writes the source of fileFormats() of file_format.h.
function(tessera_format_table file)
  get_property(formats GLOBAL PROPERTY TESSERA_FORMATS)
  set(declared "")
  set(rows "")
  foreach(format IN LISTS formats)
    get_property(endings GLOBAL PROPERTY TESSERA_ENDINGS_OF_${format})
    list(TRANSFORM endings REPLACE "(.+)" "\"\\1\"")
    list(JOIN endings ", " endings)
    string(APPEND declared "FileFormat ${format}Format();\n")
    string(APPEND rows "        withEndings(${format}Format(), {${endings}}),\n")
  endforeach()
  file(CONFIGURE OUTPUT ${file} CONTENT [[
#include "bricking/import/files/file_format.h"

#include <utility>

namespace tessera {
@declared@
namespace {
FileFormat withEndings(FileFormat format, std::vector<std::string> endings) {
    format.endings = std::move(endings);
    return format;
}
} // namespace
const std::vector<FileFormat>& fileFormats() {
    static const std::vector<FileFormat> formats = {
@rows@    };
    return formats;
}
} // namespace tessera
]] @ONLY)
endfunction()

# tessera_label_format(NAME ENDINGS .a .b [USES ...] [PRIVATE ...]): a format of files that hold labels of voxels. Its
# folder, bricking/import/labels/NAME, defines `LabelFormat NAMELabels()` (label_format.h) and calls this in a
# CMakeLists.txt: that is all that a format takes. Its room is tessera_labels_NAME.
#   ENDINGS  as above; none: its files are told by LabelFormat::isMeant alone
function(tessera_label_format name)
  cmake_parse_arguments(ARG "" "" "ENDINGS;USES;PRIVATE" ${ARGN})
  tessera_room(tessera_labels_${name} FOLDER bricking/import/labels/${name}
    USES tessera_label_formats ${ARG_USES}
    PRIVATE ${ARG_PRIVATE})
  set_property(GLOBAL APPEND PROPERTY TESSERA_LABEL_FORMATS ${name})
  set_property(GLOBAL PROPERTY TESSERA_LABEL_ENDINGS_OF_${name} ${ARG_ENDINGS})
endfunction()

# tessera_label_format_table(FILE): writes the source of labelFormats() of label_format.h.
function(tessera_label_format_table file)
  get_property(formats GLOBAL PROPERTY TESSERA_LABEL_FORMATS)
  set(declared "")
  set(rows "")
  foreach(format IN LISTS formats)
    get_property(endings GLOBAL PROPERTY TESSERA_LABEL_ENDINGS_OF_${format})
    list(TRANSFORM endings REPLACE "(.+)" "\"\\1\"")
    list(JOIN endings ", " endings)
    string(APPEND declared "LabelFormat ${format}Labels();\n")
    string(APPEND rows "        withEndings(${format}Labels(), {${endings}}),\n")
  endforeach()
  file(CONFIGURE OUTPUT ${file} CONTENT [[
#include "bricking/import/labels/label_format.h"

#include <utility>

namespace tessera {
@declared@
namespace {
LabelFormat withEndings(LabelFormat format, std::vector<std::string> endings) {
    format.endings = std::move(endings);
    return format;
}
} // namespace
const std::vector<LabelFormat>& labelFormats() {
    static const std::vector<LabelFormat> formats = {
@rows@    };
    return formats;
}
} // namespace tessera
]] @ONLY)
endfunction()
