// CGAL: box_self_intersection_d over the boxes, or those around spheres or points; then the exact test. With a number as argument of its own:
// how few boxes are compared all with all.
#include <CGAL/box_intersection_d.h>
#include <CGAL/version.h>

#include "driver.hpp"

namespace box = CGAL::Box_intersection_d;

int main(int count, char** arguments) {
    const Request request(count, arguments, {"points", "radii", "boxes"});
    if (request.threads != 1) refuse("one thread");
    // Few are the fastest in none of the sets: CGAL's own choice is 10.
    const std::ptrdiff_t cutoff = count > 5 ? std::atoi(arguments[1]) : 1000;
    const std::size_t width = request.width(), n = request.size();
    const double* numbers = request.numbers.data();

    // Addresses of boxes are what is sorted: less to move than boxes.
    using Box = box::Box_d<double, 3, box::ID_FROM_BOX_ADDRESS>;
    std::vector<Box> boxes;
    std::vector<Box*> order;
    Couples couples;
    const auto squared_distance = [&](std::size_t i, std::size_t j) {
        double sum = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            const double d = numbers[width * i + axis] - numbers[width * j + axis];
            sum += d * d;
        }
        return sum;
    };
    const auto search = [&](auto touch) {
        couples.clear();
        const auto found = [&](const Box* a, const Box* b) {
            auto i = std::uint32_t(a - boxes.data()), j = std::uint32_t(b - boxes.data());
            if (i > j) std::swap(i, j);
            if (touch(i, j)) couples.push_back({i, j});
        };
        CGAL::box_self_intersection_d(order.begin(), order.end(), found, cutoff, box::CLOSED);
    };

    converse(
        "`box_self_intersection_d`, addresses of boxes, cutoff " + std::to_string(cutoff),
        [&] {
            boxes.clear();
            boxes.reserve(n);
            for (std::size_t i = 0; i < n; i++) {
                const double* body = numbers + width * i;
                double min[3], max[3];
                for (int axis = 0; axis < 3; axis++) {
                    if (request.kind == "boxes") {
                        min[axis] = body[axis];
                        max[axis] = body[3 + axis];
                    } else {
                        // A little more, so that rounding loses nobody.
                        const double radius = (request.kind == "radii" ? body[3] : 0.5 * request.cutoff) * (1 + 1e-12) + 1e-12;
                        min[axis] = body[axis] - radius;
                        max[axis] = body[axis] + radius;
                    }
                }
                boxes.emplace_back(min, max);
            }
            order.resize(n);
            for (std::size_t i = 0; i < n; i++) order[i] = &boxes[i];
            if (request.kind == "boxes") {
                search([](std::size_t, std::size_t) { return true; });
            } else if (request.kind == "radii") {
                search([&](std::size_t i, std::size_t j) {
                    const double reach = numbers[width * i + 3] + numbers[width * j + 3];
                    return squared_distance(i, j) <= reach * reach;
                });
            } else {
                const double limit = request.cutoff * request.cutoff;
                search([&](std::size_t i, std::size_t j) { return squared_distance(i, j) <= limit; });
            }
        },
        [&] { return couples.size(); });
}
