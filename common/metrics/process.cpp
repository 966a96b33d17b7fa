// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "common/metrics/exposition.h"

namespace tessera::metrics {

void add_process(Exposition& page) {
  timespec used{};
  if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used) == 0) {
    page.family("process_cpu_seconds_total", Kind::kCounter, "Processor time used, in seconds.")
        .sample(static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec));
  }
  std::ifstream memory("/proc/self/statm");  // pages: all, resident, ...
  double pages_virtual = 0, pages_resident = 0;
  if (memory >> pages_virtual >> pages_resident) {
    const auto page_bytes = static_cast<double>(sysconf(_SC_PAGESIZE));
    page.gauge("process_resident_memory_bytes", "Memory in RAM.", pages_resident * page_bytes);
    page.gauge("process_virtual_memory_bytes", "Address space.", pages_virtual * page_bytes);
  }
  std::error_code error;
  double descriptors = 0;
  for (std::filesystem::directory_iterator fd("/proc/self/fd", error), end; !error && fd != end;
       fd.increment(error)) {
    ++descriptors;
  }
  if (!error) page.gauge("process_open_fds", "Open descriptors.", descriptors);
}

}  // namespace tessera::metrics
