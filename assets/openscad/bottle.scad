$fn=100;
rotate_extrude() difference(){ union(){ square([15,40]); translate([0,40]) intersection(){ circle(15); square(20);} translate([0,50]) square([5,12]); } offset(delta=-1.5) { square([15,40]); translate([0,40]) intersection(){ circle(15); square(20);} } translate([0,45]) square([3.5,30]); translate([-100,-100]) square([100,300]); }
