//! Work on pieces of arrays side by side, without allocating: halves of halves, down to single pieces.

/// Data that can be cut in two at a particle.
pub trait Pieces: Sized + Send {
    /// Particles below `at`, and the others.
    fn split(self, at: usize) -> (Self, Self);
    /// How many there are.
    fn count(&self) -> usize;
}

/// Calls `work(first particle, piece)` for pieces of `size` particles (a power of two times the size of the last), and joins
/// what comes out in the order of the pieces, two by two: the number of threads never shows.
pub fn each<P: Pieces, T: Send>(
    pieces: P,
    size: usize,
    work: &(impl Fn(usize, P) -> T + Sync),
    join: &(impl Fn(T, T) -> T + Sync),
) -> T {
    halve(0, pieces, size, work, join)
}

fn halve<P: Pieces, T: Send>(
    first: usize,
    pieces: P,
    size: usize,
    work: &(impl Fn(usize, P) -> T + Sync),
    join: &(impl Fn(T, T) -> T + Sync),
) -> T {
    let count = pieces.count().div_ceil(size);
    if count <= 1 {
        return work(first, pieces);
    }
    let at = count / 2 * size;
    let (low, high) = pieces.split(at);
    let (a, b) = rayon::join(|| halve(first, low, size, work, join), || halve(first + at, high, size, work, join));
    join(a, b)
}

impl<T: Send> Pieces for &mut [T] {
    fn split(self, at: usize) -> (Self, Self) {
        self.split_at_mut(at)
    }
    fn count(&self) -> usize {
        <[T]>::len(self)
    }
}

impl<T: Sync> Pieces for &[T] {
    fn split(self, at: usize) -> (Self, Self) {
        self.split_at(at)
    }
    fn count(&self) -> usize {
        <[T]>::len(self)
    }
}

impl<A: Pieces, B: Pieces> Pieces for (A, B) {
    fn split(self, at: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.split(at), self.1.split(at));
        ((a, b), (c, d))
    }
    fn count(&self) -> usize {
        self.0.count()
    }
}

impl<A: Pieces> Pieces for [A; 3] {
    fn split(self, at: usize) -> (Self, Self) {
        let [x, y, z] = self.map(|axis| axis.split(at));
        ([x.0, y.0, z.0], [x.1, y.1, z.1])
    }
    fn count(&self) -> usize {
        self[0].count()
    }
}
