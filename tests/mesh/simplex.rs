//! Meshes of simplices: volumes, shape functions, boundaries and point location.

use lateen::math::Vector;
use lateen::mesh::gmsh::parse;
use lateen::mesh::{Location, Locator, Mesh};
use proptest::prelude::*;

fn square() -> Mesh<2, 3> {
    Mesh::block(Vector([-1.0, 0.0]), Vector([2.0, 1.0]), [7, 5]).unwrap()
}

fn cube() -> Mesh<3, 4> {
    Mesh::block(Vector([0.0; 3]), Vector([1.0, 2.0, 3.0]), [3, 4, 5]).unwrap()
}

/// The block without the elements whose centre lies in its upper right quarter: an L, which is not convex.
fn l_shape() -> Mesh<2, 3> {
    let whole = Mesh::<2, 3>::block(Vector([0.0; 2]), Vector([2.0; 2]), [10, 10]).unwrap();
    let kept = |e: &usize| !(whole.center(*e)[0] > 1.0 && whole.center(*e)[1] > 1.0);
    let elements = (0..whole.elements().len()).filter(kept).map(|e| whole.elements()[e]).collect();
    Mesh::new(whole.nodes().to_vec(), elements).unwrap()
}

#[test]
fn blocks_have_their_volume_and_a_closed_boundary() {
    let (square, cube) = (square(), cube());
    assert!((square.volume() - 3.0).abs() < 1e-13 && (cube.volume() - 6.0).abs() < 1e-13);
    assert_eq!((square.elements().len(), cube.elements().len()), (70, 360));
    let perimeter: f64 = square.boundary().iter().map(|&f| square.facet_area(f).norm()).sum();
    assert!((perimeter - 8.0).abs() < 1e-13);
    let surface: f64 = cube.boundary().iter().map(|&f| cube.facet_area(f).norm()).sum();
    assert!((surface - 22.0).abs() < 1e-12);
    let sum: Vector<3> = cube.boundary().iter().map(|&f| cube.facet_area(f)).sum();
    assert!(sum.norm() < 1e-13);
    // Divergence theorem: the outward normals give the volume.
    let flux = |f: &lateen::mesh::Facet| {
        let nodes = cube.facet_nodes(*f);
        nodes.iter().map(|&n| cube.nodes()[n as usize]).sum::<Vector<3>>().dot(cube.facet_area(*f)) / 9.0
    };
    assert!((cube.boundary().iter().map(flux).sum::<f64>() - 6.0).abs() < 1e-12);
}

#[test]
fn neighbours_are_mutual_and_share_their_facet() {
    let cube = cube();
    for element in 0..cube.elements().len() {
        for k in 0..4 {
            let Some(other) = cube.neighbour(element, k) else { continue };
            assert!((0..4).any(|j| cube.neighbour(other, j) == Some(element)));
            let shared = cube.elements()[element].iter().filter(|n| cube.elements()[other].contains(n)).count();
            assert_eq!(shared, 3);
            assert!(!cube.elements()[other].contains(&cube.elements()[element][k]));
        }
    }
    let around: usize = (0..cube.nodes().len()).map(|n| cube.elements_around(n).len()).sum();
    assert_eq!(around, 4 * cube.elements().len());
    assert!(cube.elements_around(7).iter().all(|&e| cube.elements()[e as usize].contains(&7)));
}

#[test]
fn wrong_meshes_are_errors_with_their_element() {
    let nodes = || vec![Vector([0.0, 0.0]), Vector([1.0, 0.0]), Vector([0.0, 1.0]), Vector([2.0, 0.0])];
    let told = |elements: Vec<[u32; 3]>| Mesh::<2, 3>::new(nodes(), elements).unwrap_err();
    assert!(told(vec![[0, 1, 2], [0, 2, 1]]).contains("element 1 at (0.333333, 0.333333) m is inverted: its"));
    assert!(told(vec![[0, 1, 3]]).contains("element 0 at (1.000000, 0.000000) m is degenerate"));
    assert!(told(vec![[0, 1, 4]]).contains("names node 4"));
    assert!(told(vec![[0, 2, 1]; 4]).contains("is inverted, and 3 more: its"));
    assert!(told(vec![[0, 1, 2]; 2]).contains("elements 0 and 1 overlap"));
    assert!(told(vec![[0, 1, 2]; 3]).contains("3 elements share a facet"));
    assert!(told(vec![]).contains("no elements"));
    assert!(Mesh::<3, 4>::block(Vector([0.0; 3]), Vector([1.0; 3]), [usize::MAX - 1, 1, 1]).is_err());
}

#[test]
fn meshes_from_gmsh_have_their_volume_and_named_boundaries() {
    let bytes =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/gmsh/plate-4.1-binary.msh")).unwrap();
    let file = parse(&bytes).unwrap();
    let block = Mesh::<3, 4>::from_gmsh(&file, Some("block"), 2.0).unwrap();
    assert!((block.volume() - 8.0 / 6.0).abs() < 1e-12);
    let plate = Mesh::<2, 3>::from_gmsh(&file, Some("triangles"), 1.0).unwrap();
    assert!((plate.volume() - 1.0).abs() < 1e-12 && plate.sets.is_empty());
    assert!(Mesh::<2, 3>::from_gmsh(&file, Some("sheet"), 1.0).unwrap_err().contains("no simplex"));
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 7 \"inlet\"\n$EndPhysicalNames\n\
        $Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
        $Elements\n3\n1 1 2 7 1 1 4\n2 2 2 9 1 1 2 3\n3 2 2 9 1 1 3 4\n$EndElements\n";
    let square = Mesh::<2, 3>::from_gmsh(&parse(text.as_bytes()).unwrap(), None, 1.0).unwrap();
    let [inlet] = square.sets["inlet"][..] else { panic!("one facet") };
    assert_eq!(square.facet_area(inlet).0, [-1.0, 0.0]);
}

proptest! {
    #[test]
    fn shape_functions_reproduce_linear_fields(e in 0..360usize, x in prop::array::uniform3(-1.0..4.0f64), a in prop::array::uniform3(-5.0..5.0f64)) {
        let cube = cube();
        let field = |x: Vector<3>| 0.7 + Vector(a).dot(x);
        let shape = cube.shape_functions(e, Vector(x));
        let nodes = cube.corners(e);
        let interpolated: f64 = (0..4).map(|k| shape[k] * field(nodes[k])).sum();
        let gradient: Vector<3> = (0..4).map(|k| cube.simplex(e).gradient[k] * field(nodes[k])).sum();
        prop_assert!((shape.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        prop_assert!((interpolated - field(Vector(x))).abs() < 1e-10);
        prop_assert!((gradient - Vector(a)).norm() < 1e-11);
    }

    #[test]
    fn points_are_located_from_any_starting_element(x in prop::array::uniform2(-0.5..2.5f64), guess in 0..150usize) {
        let mesh = l_shape();
        let inside = |x: f64| (0.0..=2.0).contains(&x);
        let expected = inside(x[0]) && inside(x[1]) && !(x[0] > 1.0 && x[1] > 1.0);
        match Locator::new(&mesh).locate(&mesh, Vector(x), guess) {
            Location::Inside { element, shape } => {
                prop_assert!(expected);
                prop_assert!(shape.iter().all(|&n| n >= -1e-12));
                let back: Vector<2> = (0..3).map(|k| mesh.corners(element)[k] * shape[k]).sum();
                prop_assert!((back - Vector(x)).norm() < 1e-12);
            }
            Location::Outside { exit } => {
                prop_assert!(!expected);
                prop_assert_eq!(mesh.neighbour(exit.element as usize, exit.opposite as usize), None);
            }
        }
    }

    #[test]
    fn search_by_bins_and_by_walking_agree_in_3d(x in prop::array::uniform3(0.0..1.0f64), guess in 0..360usize) {
        let mesh = cube();
        let x = Vector([x[0], 2.0 * x[1], 3.0 * x[2]]);
        let locator = Locator::new(&mesh);
        let (walked, searched) = (locator.locate(&mesh, x, guess), locator.search(&mesh, x).unwrap());
        prop_assert!(walked.element().is_some());
        // On a facet the two may name different elements, which then both hold the point.
        if walked.element() != searched.element() {
            let shape = mesh.shape_functions(searched.element().unwrap(), x);
            prop_assert!(shape.iter().any(|n| n.abs() < 1e-11));
        }
    }
}
