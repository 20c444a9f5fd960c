# Where Debian looks for it.
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/colmap-structnerf RENAME copyright)

# cpack -G DEB: a package that starts from a clean shell.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME colmap-structnerf)
set(CPACK_PACKAGE_VENDOR "The StructNeRF for COLMAP authors")
set(CPACK_PACKAGE_CONTACT "The StructNeRF for COLMAP authors <structnerf@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY
  "Dense reconstruction for COLMAP with a structure-regularised radiance field")
set(CPACK_PACKAGE_DESCRIPTION
  "Adds the command structnerf_dense to COLMAP. From a sparse model it makes depth \
maps, normal maps and a fused cloud in COLMAP's formats, without a GPU. All other \
commands are handed to the stock colmap.")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# Everything but our own commands is handed to a stock COLMAP.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS colmap)
include(CPack)
