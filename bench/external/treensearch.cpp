// TreeNSearch: `run`, then the pairs out of its lists. With the argument `lists` only its own lists are timed.
#include <TreeNSearch>

#include <algorithm>
#include <cstring>

#include <omp.h>

#include "driver.hpp"

int main(int count, char** arguments) {
    const Request request(count, arguments, {"points"});
    const bool lists_only = count > 5 && std::strcmp(arguments[1], "lists") == 0;
    const Points points = request.points();
    const int n = static_cast<int>(points.size());

    // It ends the process beyond 2^15 cells of 1.5 cut-offs along an axis, its margin of 1.1 included.
    double widest = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        const auto along = [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; };
        const auto [least, most] = std::minmax_element(points.begin(), points.end(), along);
        widest = std::max(widest, (*most)[axis] - (*least)[axis]);
    }
    if (1.1 * widest / (1.5 * request.cutoff) > 32767.0) refuse("more than 2^15 cells along an axis");

    tns::TreeNSearch search;
    search.set_search_radius(request.cutoff);
    search.set_n_threads(request.threads);
    const int set = search.add_point_set(points[0].data(), n);
    search.set_active_search(set, set);

    std::vector<Couples> parts(request.threads);
    Couples couples;
    const auto collect = [&](int begin, int end, Couples& found) {
        found.clear();
        for (int i = begin; i < end; i++) {
            const tns::NeighborList list = search.get_neighborlist(set, set, i);
            for (int k = 0; k < list.size(); k++) {
                if (list[k] > i) found.push_back({std::uint32_t(i), std::uint32_t(list[k])});
            }
        }
    };
    const auto collect_all = [&] {
        if (request.threads == 1) return collect(0, n, couples);
        // Each thread its piece; then each copies it to its place.
#pragma omp parallel num_threads(request.threads)
        {
            const std::int64_t t = omp_get_thread_num();
            collect(int(t * n / request.threads), int((t + 1) * n / request.threads), parts[t]);
#pragma omp barrier
#pragma omp single
            {
                std::size_t all = 0;
                for (const Couples& part : parts) all += part.size();
                couples.resize(all);
            }
            std::size_t start = 0;
            for (int s = 0; s < t; s++) start += parts[s].size();
            std::copy(parts[t].begin(), parts[t].end(), couples.begin() + start);
        }
    };

    std::string how = "`run`, f32, memory reused; ";
    how += lists_only ? "both directions in its own lists, no pairs collected" : "pairs i < j collected from its lists";
    converse(
        how,
        [&] {
            search.run();
            if (!lists_only) collect_all();
        },
        [&] {
            if (lists_only) collect(0, n, couples);
            return couples.size();
        });
}
