//! Every instruction set of this processor computes what plain numbers give.

use super::*;

/// Calls the test for each instruction set there is.
fn on_all<V: SimdVisitor<Output = ()> + Copy>(test: V) {
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        with_simd(isa, test);
    }
}

/// Some numbers and operations on them.
struct Arithmetic<L>(std::marker::PhantomData<L>);

impl<L: Lanes> Work for Arithmetic<L> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let eps = L::Element::of(2.0).double().powi(if size_of::<L::Element>() == 4 { -23 } else { -52 });
        let values = |seed: f64| -> Vec<f64> {
            (0..L::COUNT).map(|k| L::Element::of(((k as f64 + 1.37) * seed).sin() * 3.0 + 3.5).double()).collect()
        };
        let (a, b) = (values(1.7), values(0.3));
        let lanes = |v: &[f64]| L::from_fn(|k| L::Element::of(v[k]));
        let out = |x: L| {
            let mut to = vec![L::Element::default(); L::COUNT];
            x.store(&mut to);
            to.into_iter().map(Element::double).collect::<Vec<f64>>()
        };
        let near = |got: L, want: &dyn Fn(usize) -> f64, ulps: f64| {
            for (k, got) in out(got).into_iter().enumerate() {
                let want = want(k);
                assert!((got - want).abs() <= ulps * eps * want.abs(), "lane {k}: {got} for {want}");
            }
        };
        let (x, y) = (lanes(&a), lanes(&b));
        near(x + y, &|k| a[k] + b[k], 1.0);
        near(x - y * y, &|k| a[k] - b[k] * b[k], 200.0);
        near(x / y, &|k| a[k] / b[k], 1.0);
        near(-x, &|k| -a[k], 0.0);
        near(x.sqrt(), &|k| a[k].sqrt(), 1.0);
        near(x.recip(), &|k| 1.0 / a[k], 1.0);
        near(x.rsqrt(), &|k| 1.0 / a[k].sqrt(), 2.0);
        near(x.mul_add(y, y), &|k| a[k] * b[k] + b[k], 2.0);
        near(x.ln(), &|k| a[k].ln(), 4.0);
        near(x.max(y), &|k| a[k].max(b[k]), 0.0);
        near(x.min(y), &|k| a[k].min(b[k]), 0.0);
        near(x.round(), &|k| a[k].round_ties_even(), 0.0);
        near(L::select(x.less(y), x, y), &|k| a[k].min(b[k]), 0.0);
        let bits = L::bits(x.less(y));
        assert_eq!(bits, (0..L::COUNT).map(|k| u32::from(a[k] < b[k]) << k).sum::<u32>());
        assert_eq!(L::bits(L::mask(bits)), bits);
        let sum: f64 = a.iter().sum();
        assert!((x.sum().double() - sum).abs() < 8.0 * eps * sum);
        for (sum, of) in L::sums([x, y, -x]).into_iter().zip([&a, &b, &a.iter().map(|v| -v).collect()]) {
            let want: f64 = of.iter().sum();
            assert!((sum.double() - want).abs() < 8.0 * eps * want.abs());
        }
        assert_eq!(x.largest().double(), a.iter().copied().fold(0.0, f64::max));
        let column: Vec<L::Element> = a.iter().map(|v| L::Element::of(*v)).collect();
        let long: Vec<L::Element> = (0..40).map(|k| L::Element::of(f64::from(k))).collect();
        near(
            L::lookup(&long, &[39, 3, 2, 25, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2, 3]),
            &|k| [39, 3, 2, 25, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2, 3][k].into(),
            0.0,
        );
        let index: Vec<u32> = (0..L::COUNT as u32).map(|k| (k * 7 + 3) % L::COUNT as u32).collect();
        near(L::lookup(&column, &index), &|k| a[index[k] as usize], 0.0);
        near(L::load_single(&a.iter().map(|v| *v as f32).collect::<Vec<_>>()), &|k| f64::from(a[k] as f32), 0.0);
        near(L::load_double(&a), &|k| a[k], 0.0);
        let largest = if size_of::<L::Element>() == 4 { 88.7 } else { 709.7 };
        for step in -400..=400 {
            let t = L::Element::of(largest * f64::from(step) / 400.0);
            let want = t.double().exp();
            // Below the smallest normal number there may be 0.
            if t.double() < if largest < 100.0 { -87.0 } else { -708.0 } {
                assert!(out(L::splat(t).exp()).iter().all(|got| *got == 0.0 || (got / want - 1.0).abs() < 0.01));
            } else {
                near(L::splat(t).exp(), &|_| want, 4.0);
            }
        }
        for step in -600..=600 {
            let t = L::Element::of((largest * f64::from(step) / 620.0).exp()).double();
            near(L::constant(t).ln(), &|_| t.ln(), 2.0);
            // Near 1, where all digits but those of f cancel.
            let t = L::Element::of(1.0 + f64::from(step) / 1500.0).double();
            near(L::constant(t).ln(), &|_| t.ln(), 2.0);
        }
        let special = |x: f64| out(L::constant(x).ln())[0];
        assert_eq!(special(1.0), 0.0);
        assert_eq!(special(0.0), f64::NEG_INFINITY);
        assert_eq!(special(f64::INFINITY), f64::INFINITY);
        assert!(special(-1.0).is_nan() && special(f64::NEG_INFINITY).is_nan() && special(f64::NAN).is_nan());
        let special = |x: f64| out(L::constant(x).exp())[0];
        assert_eq!(special(f64::NEG_INFINITY), 0.0);
        assert_eq!(special(-1e5), 0.0);
        assert_eq!(special(1e5), f64::INFINITY);
        assert_eq!(special(f64::INFINITY), f64::INFINITY);
        assert!(special(f64::NAN).is_nan());
        assert_eq!(special(0.0), 1.0);
    }
}

#[test]
fn lanes_compute_what_numbers_compute() {
    #[derive(Clone, Copy)]
    struct All;
    impl SimdVisitor for All {
        type Output = ();
        fn visit<I: Simd>(self, simd: I) {
            simd.vectorize(Arithmetic::<I::F32>(std::marker::PhantomData));
            simd.vectorize(Arithmetic::<I::F64>(std::marker::PhantomData));
        }
    }
    on_all(All);
}

/// Slots, differences, compression.
struct Slots<I>(std::marker::PhantomData<I>);

impl<I: Simd> Work for Slots<I> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut fixed: Box<Tile<FixedSlot>> = vec![[0; 4]; SLOTS].try_into().unwrap();
        let mut double: Box<Tile<DoubleSlot>> = vec![DoubleSlot::default(); SLOTS].try_into().unwrap();
        for k in 0..SLOTS {
            let x = |a: usize| (k as i32).wrapping_mul(2_654_435_761_u32 as i32).rotate_left(7 * a as u32);
            fixed[k] = [x(0), x(1), x(2), (k % 5) as i32];
            double[k] = DoubleSlot { x: [0, 1, 2].map(|a| f64::from(x(a))), kind: (k % 3) as u64 };
        }
        let index: Vec<u16> = (0..16u16).map(|k| k.wrapping_mul(4099).wrapping_add(65521)).collect();
        let own = [i32::MAX - 5, -7, 1 << 30, 0];
        let (d, kinds) = I::F32::differences(I::F32::own(&own), &fixed, &index);
        let mut got = vec![0.0f32; 16];
        for (a, d) in d.into_iter().enumerate() {
            d.store(&mut got);
            for k in 0..I::F32::COUNT {
                assert_eq!(got[k], own[a].wrapping_sub(fixed[index[k] as usize][a]) as f32);
            }
        }
        for types in [5usize, 40] {
            let mut column: Vec<f32> = (0..types).map(|k| k as f32 + 0.5).collect();
            column.resize(types.max(I::F32::COUNT), 0.0);
            I::F32::coefficient(&column, kinds).store(&mut got);
            for k in 0..I::F32::COUNT {
                assert_eq!(got[k], fixed[index[k] as usize][3] as f32 + 0.5);
            }
        }
        let own = DoubleSlot { x: [0.25, -3.0, 1e9], kind: 0 };
        let (d, kinds) = I::F64::differences(I::F64::own(&own), &double, &index);
        let mut got = vec![0.0f64; 16];
        for (a, d) in d.into_iter().enumerate() {
            d.store(&mut got);
            for k in 0..I::F64::COUNT {
                assert_eq!(got[k], own.x[a] - double[index[k] as usize].x[a]);
            }
        }
        for types in [3usize, 30] {
            let mut column: Vec<f64> = (0..types).map(|k| k as f64 + 0.5).collect();
            column.resize(types.max(I::F64::COUNT), 0.0);
            I::F64::coefficient(&column, kinds).store(&mut got);
            for k in 0..I::F64::COUNT {
                assert_eq!(got[k], double[index[k] as usize].kind as f64 + 0.5);
            }
        }
        let coordinates: Vec<i32> = (0..16).map(|k| k * 1_000_003 - 77).collect();
        let mut got = vec![0.0f32; 16];
        I::F32::fixed_differences(-5, &coordinates).store(&mut got);
        for k in 0..I::F32::COUNT {
            assert_eq!(got[k], (-5 - coordinates[k]) as f32);
        }
        for bits in 0..1u32 << I::F32::COUNT {
            let mut to = [0u16; 16];
            I::F32::compress(100, bits, &mut to);
            let want: Vec<u16> = (0..16).filter(|k| bits >> k & 1 == 1).map(|k| 100 + k).collect();
            assert_eq!(to[..want.len()], want);
        }
        let quanta: Vec<f64> = (0..16).map(|k| f64::from(k) * 1.0e13 + 0.3 - 7.0e13).collect();
        let kinds: Vec<u32> = (0..16).collect();
        let mut slots = vec![[0; 4]; 16];
        let x = I::F64::load(&quanta);
        I::F64::fixed_slots([x, -x, x + x], &kinds, &mut slots);
        for k in 0..I::F64::COUNT {
            let whole = |v: f64| v.round_ties_even() as i64 as i32;
            assert_eq!(slots[k], [whole(quanta[k]), whole(-quanta[k]), whole(2.0 * quanta[k]), k as i32]);
        }
    }
}

#[test]
fn slots_and_lists_are_those_of_plain_code() {
    #[derive(Clone, Copy)]
    struct All;
    impl SimdVisitor for All {
        type Output = ();
        fn visit<I: Simd>(self, simd: I) {
            simd.vectorize(Slots::<I>(std::marker::PhantomData));
        }
    }
    on_all(All);
}

#[test]
fn names_are_read_back() {
    for isa in Isa::ALL {
        assert_eq!(Isa::named(isa.name()), Some(isa));
    }
    assert!(Isa::detect().is_available());
}
