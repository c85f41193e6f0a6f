$fn=60; function naca(x,t)=5*t*(0.2969*sqrt(x)-0.126*x-0.3516*x*x+0.2843*x*x*x-0.1036*x*x*x*x);
foil=concat([for(i=[0:20]) let(x=pow(i/20,2)) [x,naca(x,.15)]],[for(i=[19:-1:1]) let(x=pow(i/20,2)) [x,-naca(x,.15)]]);
cylinder(r=5,h=8); for(a=[0,120,240]) rotate(a) translate([0,0,4]) rotate([0,90,0]) linear_extrude(40,twist=35,scale=0.6,slices=40) translate([-4,0]) scale(9) polygon(foil);
