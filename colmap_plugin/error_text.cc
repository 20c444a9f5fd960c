#include "colmap_plugin/error_text.h"

#include <exception>
#include <new>

namespace structnerf {

std::string CurrentErrorText() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return "The memory did not suffice; close other programs or use smaller "
           "images.";
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "An error of an unknown kind occurred; please report it with the "
           "log.";
  }
}

}  // namespace structnerf
