// Highway's library times the timer when it is loaded, with an instruction that
// valgrind does not know on some machines. This one is found before its own.

#include <cstdint>

namespace hwy {
namespace platform {

uint64_t TimerResolution() { return 1; }

}  // namespace platform
}  // namespace hwy
