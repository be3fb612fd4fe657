// vesin: half list, pairs only, memory kept from call to call.
#include <vesin.h>

#include "driver.hpp"

int main(int count, char** arguments) {
    const Request request(count, arguments, {"points"});
    const Points own = request.points();
    const double box[3][3] = {};
    const bool periodic[3] = {};
    VesinOptions options{};
    options.cutoff = request.cutoff;
    options.algorithm = VesinAutoAlgorithm;
    options.n_threads = request.threads;
    VesinNeighborList list;
    const auto* points = reinterpret_cast<const double (*)[3]>(own.data());
    converse(
        "`vesin_neighbors`, half list, pairs only, memory reused",
        [&] {
            const char* error = nullptr;
            const VesinDevice device{VesinCPU, 0};
            if (vesin_neighbors(points, own.size(), box, periodic, device, options, &list, &error)) {
                refuse(error == nullptr ? "failed" : error);
            }
        },
        [&] { return list.length; });
}
