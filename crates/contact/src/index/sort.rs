//! Sorts a few numbers without data-dependent branches.

/// K.E. Batcher's odd-even merge sort (AFIPS Spring Joint Computer Conference, 1968) of `N` numbers, as `C`
/// pairs of places that are put in order one after the other.
const fn network<const N: usize, const C: usize>() -> [(usize, usize); C] {
    let mut network = [(0, 0); C];
    let mut next = 0;
    let mut sorted = 1;
    while sorted < N {
        let mut step = sorted;
        while step > 0 {
            let mut start = step % sorted;
            while start + step < N {
                let mut k = 0;
                while k < step && start + k + step < N {
                    let (low, high) = (start + k, start + k + step);
                    if low / (2 * sorted) == high / (2 * sorted) {
                        network[next] = (low, high);
                        next += 1;
                    }
                    k += 1;
                }
                start += 2 * step;
            }
            step /= 2;
        }
        sorted *= 2;
    }
    assert!(next == C);
    network
}

/// Size of the widest network.
pub(super) const FEW: usize = 32;

const OF_16: [(usize, usize); 63] = network::<16, 63>();
const OF_32: [(usize, usize); 191] = network::<32, 191>();

/// Sorts `numbers`, none of which is larger than `largest`.
#[inline]
pub(super) fn sort<N: Ord + Copy>(numbers: &mut [N], largest: N) {
    match numbers.len() {
        0..=16 => pass(&OF_16, [largest; 16], numbers),
        17..=FEW => pass(&OF_32, [largest; FEW], numbers),
        _ => numbers.sort_unstable(),
    }
}

#[inline]
fn pass<N: Ord + Copy, const FEW: usize>(network: &[(usize, usize)], mut few: [N; FEW], numbers: &mut [N]) {
    for (place, &number) in few.iter_mut().zip(&*numbers) {
        *place = number;
    }
    for &(low, high) in network {
        let (a, b) = (few[low], few[high]);
        few[low] = a.min(b);
        few[high] = a.max(b);
    }
    for (number, &sorted) in numbers.iter_mut().zip(&few) {
        *number = sorted;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A network that sorts all sequences of zeros and ones sorts everything (the 0-1 principle).
    #[test]
    fn all_sequences_of_zeros_and_ones_are_sorted() {
        for n in 0..=16 {
            for bits in 0_u32..1 << n {
                let mut numbers: Vec<u32> = (0..n).map(|k| bits >> k & 1).collect();
                sort(&mut numbers, u32::MAX);
                let ones = bits.count_ones() as usize;
                assert!(
                    numbers[..n - ones].iter().all(|&x| x == 0)
                        && numbers[n - ones..].iter().all(|&x| x == 1)
                );
            }
        }
    }

    #[test]
    fn more_numbers_are_sorted_too() {
        for n in 17..100 {
            for factor in [37, 41, 53, 100, 0] {
                let mut numbers: Vec<u64> = (0..n).map(|k| k * factor % 101).collect();
                let mut expected = numbers.clone();
                expected.sort_unstable();
                sort(&mut numbers, u64::MAX);
                assert_eq!(numbers, expected);
            }
        }
    }
}
