# What an installation holds besides programs and modules: documents, pages of the manual, completion in shells, and what
# desktops ask for. Components: `program`, which draws without a window, `window`, `bench`, `python`. Packages of them are made
# by packages/make.sh.
if(NOT TARGET tessera)
  return()
endif()
set(packaging ${PROJECT_SOURCE_DIR}/cmake/packages)

install(FILES README.md LICENSE SECURITY.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT program
  FILES_MATCHING PATTERN "*.md" PATTERN "*.schema.json" PATTERN "images/*.png"
  PATTERN measurements EXCLUDE PATTERN window EXCLUDE PATTERN design.md EXCLUDE)

if(TESSERA_WITH_WINDOW)
  set(name org.tessera.Tessera)
  set(desktop ${packaging}/desktop)
  install(FILES ${desktop}/${name}.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT window)
  install(FILES ${desktop}/${name}.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT window)
  install(FILES ${desktop}/${name}.metainfo.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/metainfo COMPONENT window)
  install(FILES ${desktop}/${name}.mime.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages RENAME ${name}.xml
    COMPONENT window)
endif()

# Debian's packages (cpack -G DEB): a component each. tessera draws without a window, and needs neither OpenGL nor a display.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tessera)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "Tessera maintainers <maintainers@tessera.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENTS_ALL program)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# Names of files, licences and texts as Debian has them, and the time of the version on all files.
set(CPACK_PRE_BUILD_SCRIPTS ${packaging}/debian/stage.cmake)
set(CPACK_TESSERA_DEBIAN ${packaging}/debian)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME tessera)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "draws CT, MR and PET volumes of any size
Tessera draws lit volumes of any size within a memory budget, from DICOM,
NIfTI, NRRD, OME-Zarr, HDF5, OpenVDB and stacks of pictures, and measures the
error of every picture. It is not for diagnosis.
.
This package draws without a window and without OpenGL.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "ca-certificates")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "tessera-window, libegl1, libgl1-mesa-dri, ffmpeg")
if(TESSERA_WITH_WINDOW)
  list(APPEND CPACK_COMPONENTS_ALL window)
  set(CPACK_DEBIAN_WINDOW_PACKAGE_NAME tessera-window)
  set(CPACK_COMPONENT_WINDOW_DESCRIPTION "window for looking at CT, MR and PET volumes
Tessera draws lit volumes of any size within a memory budget. This package
has its window: transfer functions over the histogram, three linked planes,
segmentations, cuts, meshes, distances and flights through hollow organs.")
  set(CPACK_DEBIAN_WINDOW_PACKAGE_DEPENDS "tessera (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_WINDOW_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, libxcursor1, libxi6, libxinerama1, libxrandr2, libxxf86vm1")
endif()
if(TARGET tessera_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tessera)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "draws CT, MR and PET volumes of any size (Python 3)
Tessera draws lit volumes of any size within a memory budget. This package
draws them from Python, with arrays of NumPy.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "tessera (= ${PROJECT_VERSION}), python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
endif()
include(CPack)
