# OpenImageIO::OpenImageIO
find_package(OpenImageIO REQUIRED)
# Debian 12's target names an include folder that its package does not bring; CMake would stop over it.
get_target_property(folders OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER folders EXCLUDE REGEX "opencv4")
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${folders}")
